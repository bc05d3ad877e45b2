// Compares results of `skywave bench --json`: how many times as long B takes as A, with intervals.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/names.h"
#include "bench/measure/bench_record.h"
#include "bench/measure/statistics.h"

namespace skywave {

inline constexpr std::string_view kWholeSuite = "all";

// Repetitions of one run share what slows that run, so their interval alone is too narrow. Other
// load only ever adds to a time: the slowest quarter is left out, and the least times have to
// agree.
struct SpeedRatio {
  std::string name;  // of a scene, or kWholeSuite
  double a, b;       // [s] median of the renders; NaN for kWholeSuite
  Ratio ratio;       // of the time of B to that of A
  double least;      // the same of the least times; NaN where several runs were compared

  // Returns whether B certainly takes longer by more than `threshold` (0.05: 5 %): noise may hide a
  // slow-down, but hardly ever makes one up.
  bool slower(double threshold) const {
    return ratio.interval.low > 1 + threshold && !(least <= 1 + threshold);
  }
  // Returns whether a slow-down by `threshold` could hide in the interval, because that is wide.
  bool may_hide(double threshold) const {
    const auto [low, high] = ratio.interval;
    return !(high <= 1 + threshold || high <= low * (1 + threshold) * (1 + threshold));
  }
  bool faster(double threshold) const {
    return ratio.interval.high * (1 + threshold) < 1 && !(least * (1 + threshold) >= 1);
  }
};

// Compares the repetitions of one run of A and one of B, scene by scene of a suite. Each has at
// least two.
SpeedRatio CompareRuns(const std::string& name, std::span<const std::vector<double>> a,
                       std::span<const std::vector<double>> b);

enum class SpeedVerdict { kPassed, kFaster, kSlower, kCannotTell };
template <>
inline constexpr auto kEnumNames<SpeedVerdict> =
    std::to_array<Named<SpeedVerdict>>({{SpeedVerdict::kPassed, "passed"},
                                        {SpeedVerdict::kFaster, "faster"},
                                        {SpeedVerdict::kSlower, "slower"},
                                        {SpeedVerdict::kCannotTell, "cannot tell"}});

struct BenchComparison {
  std::size_t pairs = 1;            // of files
  std::vector<SpeedRatio> ratios;   // the whole first if there is more than one scene
  std::vector<std::string> notes;   // settings in which A and B differ
  std::vector<std::string> doubts;  // why times of a run are not to be trusted
};

// The verdict by all ratios, and the names of those that it is by.
struct JudgedSpeed {
  SpeedVerdict verdict = SpeedVerdict::kPassed;
  std::vector<std::string> names;
};
// Two runs that are doubted tell nothing: what disturbed one of them looks like a difference. The
// pairs of many have that in their interval.
JudgedSpeed Judge(const BenchComparison& comparison, double threshold);

// `records` are runs of A and B in turn: A B A B. Two files are compared by their repetitions;
// more of them by the medians of each pair, which also takes in what differs from run to run.
// Throws InputError for files that did not render the same, or have too few repetitions.
BenchComparison CompareRecords(std::span<const BenchRecord> records);

}  // namespace skywave
