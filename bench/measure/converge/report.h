// The results of comparing strategies and integrators, and their reports for programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/measure/converge.h"
#include "bench/measure/plot.h"
#include "bench/measure/summary.h"

namespace skywave {

struct ConvergeReport {
  const RenderJob* job = nullptr;
  std::string scene;
  std::string command;  // the one that repeats the measurement; empty: none does
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
};

// Returns warnings to read before believing the figures, one line each.
std::vector<std::string> FindWarnings(const ConvergeReport& report);

// docs/converge.md describes the keys.
std::string JsonText(const ConvergeReport& report);
// Plots error against time, and error against samples.
std::vector<Plot> Plots(const ConvergeReport& report);

}  // namespace skywave
