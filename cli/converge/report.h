// What skywave converge found: a table for people, JSON for programs, curves, and a page of all.
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
  std::string command;  // as it was called
  ConvergeSettings settings;
  Reference reference;
  std::string reference_source;                    // "auto" or a file
  std::optional<Integrator> reference_integrator;  // of auto
  std::uint32_t reference_samples = 0;             // a pixel; 0: unknown
  double reference_seconds = 0;
  std::vector<Contestant> contestants;
  std::vector<CurveRuns> curves;  // of the contestants
  TargetSummary summary;
  std::vector<std::string> warnings;
  ToneMapping tone;  // of pictures on the page
};

// What a reader of the figures has to know before believing them, one line each.
std::vector<std::string> FindWarnings(const ConvergeReport& report);

// Rows of cells; the first row is the heading.
using TextTable = std::vector<std::vector<std::string>>;
std::string Introduction(const ConvergeReport& report);
TextTable BudgetTable(const ConvergeReport& report);  // a row for every contestant and budget
std::string TargetText(const ConvergeReport& report);
TextTable TargetTable(const ConvergeReport& report);  // a row for every contestant
std::string Text(const TextTable& table);             // columns aligned by spaces
// Keys: docs/converge.md.
nlohmann::ordered_json Json(const ConvergeReport& report);
// Error against time, and error against samples.
std::vector<LogPlot> Plots(const ConvergeReport& report);
// One page that needs no other file and no network.
std::string Html(const ConvergeReport& report);

}  // namespace skywave
