// Reports a run of the suite as text, counters, JSON (docs/bench_json.md) and a page.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bench/measure/machine.h"
#include "bench/measure/suite.h"

namespace skywave {

inline constexpr std::string_view kRayOrderNames[kRayOrders] = {"traced", "wave", "frame"};

struct SuiteReport {
  bool full = false;
  Machine machine;
  RenderOptions options;  // those of the first scene; threads, wave and backend hold for all
  int repetitions = 0;
  bool replayed = true;  // also rendered with other numbers of threads
  std::vector<SuiteResult> results;
};

// A run of the suite that was kept as JSON.
struct HistoryEntry {
  std::string name;  // name of the file
  SuiteSummary summary;
};
// Throws InputError if `path` is not such a file.
HistoryEntry ReadHistory(const std::string& path);

// Returns its keys and values; 0: not measured.
std::vector<std::pair<std::string_view, double>> Figures(const SuiteSummary& summary);
// Returns one greppable line without the keys of figures that were not measured.
std::string SummaryLine(const SuiteSummary& summary);
// Names the figures that were not measured and the reason; empty if all were.
std::string NotMeasured(const SuiteReport& report);
// Return the texts before and after the summary.
std::string Headline(const SuiteReport& report);
std::string SuiteText(const SuiteReport& report);
// Returns everything that depends on neither time nor threads: the same text on every machine with
// AVX2.
std::string CountersText(const std::vector<SuiteResult>& results);
// Returns the median of the renders and how they spread.
std::string RenderText(const Speed& speed);
// Prints why the times of `scene` are not to be trusted; nothing if they are.
void PrintDoubts(const Speed& speed, std::string_view scene);
// Prints what of the machine's settings lets times depend on what ran before.
void PrintGovernor(const Machine& machine);
// Returns what the processor counted meanwhile; empty if it was not asked or does not say.
std::string HardwareText(const Speed& speed);
// Return each kind of rays in the render and raw, all calls to raw Embree, and the gain by
// ordering.
std::string RayText(const Speed& speed);
std::string ReplayText(const Speed& speed);

// Returns the width for which lanes are shown on this machine, one of kLaneWidths.
std::uint32_t ShownLanes(const Machine& machine);

// Returns null for 0, which stands for a figure that was not measured.
nlohmann::ordered_json Measured(double value);
nlohmann::ordered_json Json(const Machine& machine);
nlohmann::ordered_json Json(const Speed& speed);
nlohmann::ordered_json Json(const SuiteReport& report);
std::string Html(const SuiteReport& report, const std::vector<HistoryEntry>& history);

}  // namespace skywave
