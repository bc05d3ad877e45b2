// What the guard of a scene keeps of a run, and how a later run is compared with it: counters to
// the last digit, instructions within a limit, times by intervals (docs/regression.md).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/names.h"
#include "bench/measure/counters.h"
#include "bench/measure/instructions.h"

namespace skywave {

// The parts of a baseline, each with the exit code of a run that fails in it; the first one that
// fails decides.
enum class BaselineGate { kCounters, kInstructions, kTime };
template <>
inline constexpr auto kEnumNames<BaselineGate> =
    std::to_array<Named<BaselineGate>>({{BaselineGate::kCounters, "counters"},
                                        {BaselineGate::kInstructions, "instructions"},
                                        {BaselineGate::kTime, "time"}});
inline constexpr int ExitCodeOf(BaselineGate gate) { return 1 + int(gate); }

using NamedTexts = std::vector<std::pair<std::string, std::string>>;

struct Baseline {
  std::vector<std::string> reasons;  // why each of its versions was taken, the last one last
  std::string version;               // of the program
  NamedTexts options;                // what decides the picture and how it is cut into waves
  std::string hits;                  // the instructions by which Embree found the hits: "isa=avx2"
  std::vector<Counter> counters = {};
  std::string toolchain = {};            // what `instructions` belong to
  StageInstructions instructions = {};   // empty: not counted
  std::string not_counted = {};          // why; not in files
  NamedTexts machine = {};               // what `seconds` belong to
  std::vector<double> seconds = {};      // [s] every render; empty: not measured
  std::vector<std::string> doubts = {};  // why they are not to be trusted
};

nlohmann::ordered_json Json(const Baseline& baseline);
std::string JsonText(const Baseline& baseline);
// Throws InputError for a file that is not a baseline.
Baseline ReadBaseline(const std::string& path);
Baseline BaselineOf(const nlohmann::json& json, const std::string& file);

// The result of a gate.
struct GateResult {
  BaselineGate gate;
  // Unclear: the times are too uncertain to tell.
  enum { kPassed, kFailed, kSkipped, kUnclear } verdict = kPassed;
  std::string summary;             // half a line; why it was skipped or is unclear
  std::vector<std::string> lines;  // one for each thing that differs
};

// The share of a stage's instructions by which it may differ.
inline constexpr double kInstructionLimit = 0.005;

// Compares `now` with `baseline` by `gates`. `threshold`: how much slower it may be, 0.05 is 5 %.
// Throws InputError for `path`, the file of the baseline, if it is that of another picture.
std::vector<GateResult> JudgeBaseline(const Baseline& baseline, const Baseline& now,
                                      const std::vector<BaselineGate>& gates, double threshold,
                                      const std::string& path);

// Returns the exit code of the first gate that failed, or 0.
int ExitCodeOf(const std::vector<GateResult>& results);

}  // namespace skywave
