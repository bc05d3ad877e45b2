// What a run of the suite tells: text, counters, JSON (docs/bench_json.md) and a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "measure/machine.h"
#include "measure/suite.h"

namespace skywave {

inline constexpr std::string_view kRayKindNames[kRayKinds] = {"camera", "bounce", "shadow"};
inline constexpr std::string_view kRayOrderNames[kRayOrders] = {"traced", "wave", "frame"};

struct SuiteReport {
  bool full = false;
  Machine machine;
  RenderOptions options;  // of the first scene: threads, wave and backend are those of all
  int repetitions = 0;
  std::vector<SuiteResult> results;
};

// A run of the suite that was kept as JSON.
struct HistoryEntry {
  std::string name;  // of the file
  SuiteSummary summary;
};
// Throws InputError where `path` is no such file.
HistoryEntry ReadHistory(const std::string& path);

// Greppable and the same keys for ever: figures that were not measured are "nan".
std::string SummaryLine(const SuiteSummary& summary);
// What is said before the summary, and what is said after it.
std::string Headline(const SuiteReport& report);
std::string SuiteText(const SuiteReport& report);
// Everything that depends on neither time nor threads: the same text on every machine with AVX2.
std::string CountersText(const std::vector<SuiteResult>& results);
// Raw Embree: the best call for each order, and what ordering gains.
std::string ReplayText(const Speed& speed);

nlohmann::ordered_json Json(const Speed& speed);
nlohmann::ordered_json Json(const SuiteReport& report);
std::string Html(const SuiteReport& report, const std::vector<HistoryEntry>& history);

// Median of stage `i` over the repetitions [s], summed over workers.
double StageSeconds(const Speed& speed, std::uint32_t stage);
double BusySeconds(const Speed& speed);  // of all stages

}  // namespace skywave
