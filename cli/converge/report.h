// Reports the results of skywave converge for people: tables, and a page with everything.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"
#include "measure/converge/report.h"

namespace skywave {

// Rows of cells; the first row is the heading.
using TextTable = std::vector<std::vector<std::string>>;
std::string Introduction(const ConvergeReport& report);
TextTable BudgetTable(const ConvergeReport& report);  // one row per contestant and budget
std::string TargetText(const ConvergeReport& report);
TextTable TargetTable(const ConvergeReport& report);  // one row per contestant
std::string Text(const TextTable& table);             // columns aligned by spaces
// Returns one page that needs no other file and no network; `tone` is that of its pictures.
std::string Html(const ConvergeReport& report, const ToneMapping& tone);

}  // namespace skywave
