// Reports the results of skywave converge: a table for people, JSON for programs, curves, and a
// page with everything.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "measure/converge.h"
#include "measure/plot.h"
#include "measure/summary.h"

namespace skywave {

struct ConvergeReport {
  const RenderJob* job = nullptr;
  std::string scene;
  std::string command;  // as typed
  ConvergeSettings settings;
  Reference reference;
  std::string reference_source;                    // "auto" or a file
  std::optional<Integrator> reference_integrator;  // set if it was computed ("auto")
  std::uint32_t reference_samples = 0;             // per pixel; 0: unknown
  double reference_seconds = 0;
  std::vector<Contestant> contestants;
  std::vector<CurveRuns> curves;  // one per contestant
  TargetSummary summary;
  std::vector<std::string> warnings;
  ToneMapping tone;  // for the pictures on the page
};

// Returns warnings to read before believing the figures, one line each.
std::vector<std::string> FindWarnings(const ConvergeReport& report);

// Rows of cells; the first row is the heading.
using TextTable = std::vector<std::vector<std::string>>;
std::string Introduction(const ConvergeReport& report);
TextTable BudgetTable(const ConvergeReport& report);  // one row per contestant and budget
std::string TargetText(const ConvergeReport& report);
TextTable TargetTable(const ConvergeReport& report);  // one row per contestant
std::string Text(const TextTable& table);             // columns aligned by spaces
// docs/converge.md describes the keys.
nlohmann::ordered_json Json(const ConvergeReport& report);
// Plots error against time, and error against samples.
std::vector<LogPlot> Plots(const ConvergeReport& report);
// Returns one page that needs no other file and no network.
std::string Html(const ConvergeReport& report);

}  // namespace skywave
