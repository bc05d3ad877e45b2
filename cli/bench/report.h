// What a run of the suite tells: text, counters, JSON (docs/bench_json.md) and a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "measure/machine.h"
#include "measure/suite.h"

namespace skywave {

inline constexpr std::string_view kRayOrderNames[kRayOrders] = {"traced", "wave", "frame"};

struct SuiteReport {
  bool full = false;
  Machine machine;
  RenderOptions options;  // of the first scene: threads, wave and backend are those of all
  int repetitions = 0;
  bool replayed = true;  // and rendered by other numbers of threads
  std::vector<SuiteResult> results;
};

// A run of the suite that was kept as JSON.
struct HistoryEntry {
  std::string name;  // of the file
  SuiteSummary summary;
};
// Throws InputError where `path` is no such file.
HistoryEntry ReadHistory(const std::string& path);

// Its keys and values; 0: not measured.
std::vector<std::pair<std::string_view, double>> Figures(const SuiteSummary& summary);
// One greppable line; the keys of what was not measured are left out.
std::string SummaryLine(const SuiteSummary& summary);
// Says what was not measured and why; empty where all was.
std::string NotMeasured(const SuiteReport& report);
// What is said before the summary, and what is said after it.
std::string Headline(const SuiteReport& report);
std::string SuiteText(const SuiteReport& report);
// Everything that depends on neither time nor threads: the same text on every machine with AVX2.
std::string CountersText(const std::vector<SuiteResult>& results);
// Each kind of rays in the render and raw, all calls to raw Embree, and what ordering gains.
std::string RayText(const Speed& speed);
std::string ReplayText(const Speed& speed);

// The width that lanes are shown for on this machine, one of kLaneWidths.
std::uint32_t ShownLanes(const Machine& machine);

nlohmann::ordered_json Json(const Speed& speed);
nlohmann::ordered_json Json(const SuiteReport& report);
std::string Html(const SuiteReport& report, const std::vector<HistoryEntry>& history);

}  // namespace skywave
