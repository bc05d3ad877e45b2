// Reports the results of skywave converge for people: tables, and a page with everything.
#pragma once

#include <string>

#include "bench/measure/converge/report.h"
#include "cli/text_table.h"
#include "image/image.h"

namespace skywave {

std::string Introduction(const ConvergeReport& report);
TextTable BudgetTable(const ConvergeReport& report);  // one row per contestant and budget
std::string TargetText(const ConvergeReport& report);
TextTable TargetTable(const ConvergeReport& report);  // one row per contestant
// Returns one page that needs no other file and no network; `tone` is that of its pictures.
std::string Html(const ConvergeReport& report, const ToneMapping& tone);

}  // namespace skywave
