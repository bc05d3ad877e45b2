// What the measured curves say together: how long each strategy takes to the same error.
#pragma once

#include <optional>
#include <vector>

#include "measure/converge.h"
#include "measure/statistics.h"

namespace skywave {

// All repetitions of one strategy at growing budgets: [rung][repeat].
struct CurveRuns {
  std::vector<std::vector<double>> seconds, errors;
};
CurveRuns MakeCurveRuns(const Contestant& contestant, ErrorMeasure measure);

// Median of the times and mean of the errors of every rung.
std::vector<CurvePoint> Curve(const CurveRuns& runs);

struct TimeToTarget {
  Crossing time;      // [s]
  Interval interval;  // of the time [s]; ends are 0 or infinite beyond the measured curve
  double speed_up;    // of the first curve's time over this one's; NaN unless both are inside
  Interval speed_up_interval;  // unknown where a resampled curve misses the target
};

struct TargetSummary {
  double target;    // the error
  bool from_first;  // it is what the first curve reaches at its end
  std::vector<TimeToTarget> times;
};

// When each curve comes down to `target`; unset: to the mean error of the first curve's last rung.
// Intervals are bootstrapped: repetitions are drawn anew, the same ones for all curves, because
// what ran in the same repeat met the same machine; a target of the first curve is drawn with it.
// Curves need the same number of repeats in every rung. The same result every time.
TargetSummary SummarizeTarget(const std::vector<CurveRuns>& curves, std::optional<double> target);

}  // namespace skywave
