// Summarises the measured curves: the time that each strategy takes to reach the same error.
#pragma once

#include <optional>
#include <vector>

#include "bench/measure/converge.h"
#include "bench/measure/statistics.h"

namespace skywave {

// All repetitions of one strategy at growing budgets: [rung][repeat].
struct CurveRuns {
  std::vector<std::vector<double>> seconds, errors;
};
CurveRuns MakeCurveRuns(const Contestant& contestant, ErrorMeasure measure);

// Returns the median time and the mean error of every rung.
std::vector<CurvePoint> Curve(const CurveRuns& runs);

struct TimeToTarget {
  Crossing time;      // [s]
  Interval interval;  // [s] interval of the time; ends are 0 or infinite beyond the measured curve
  double speed_up;    // the first curve's time over this one's; NaN unless both are inside
  Interval speed_up_interval;  // unknown if a resampled curve misses the target
};

struct TargetSummary {
  double target;    // the error
  bool from_first;  // the target is the final error of the first curve
  std::vector<TimeToTarget> times;
};

// Finds the time at which each curve reaches `target`, by default the mean error of the first
// curve's last rung. Intervals are bootstrapped: repetitions are resampled, with the same draws for
// all curves because runs of the same repeat shared the state of the machine; a target taken from
// the first curve is resampled with it. All rungs of all curves need the same number of repeats.
// The result is the same every time.
TargetSummary SummarizeTarget(const std::vector<CurveRuns>& curves, std::optional<double> target);

}  // namespace skywave
