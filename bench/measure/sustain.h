// Renders for a while without a pause, to see whether a machine keeps its speed as it grows warm.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "bench/measure/statistics.h"
#include "job/job.h"

namespace skywave {

// One round: every job is rendered once.
struct SustainedRound {
  double start;  // [s] since the first round
  double rate;   // [samples/s], the geometric mean over the jobs
};

// Rounds are put together in up to this many blocks of equal time, because rounds that follow each
// other are slowed down by the same things, and an interval wants independent values.
inline constexpr int kSustainBlocks = 20;

struct SustainedSpeed {
  double seconds = 0;  // from the first round to the end of the last one
  std::vector<SustainedRound> rounds;
  std::vector<CurvePoint> blocks;  // middle [s] and mean rate [samples/s]
  double first = 0, last = 0;      // mean rates of the first and the last quarter of the blocks
  Ratio last_to_first;
  // Change of the rate within a minute over its mean: -0.01 is 1 % less.
  Slope drift_per_minute;
};

// Renders all of `jobs` in turn until `seconds` have passed; the last round is completed. `show`
// is called after each round with the share of the time that is over.
SustainedSpeed MeasureSustained(std::span<const RenderJob* const> jobs, double seconds,
                                const std::function<void(double done)>& show);

// Fills in the rest from rounds, at least one, that ended after `seconds`. The drift has an
// interval from six rounds on, and the ratio from sixteen.
SustainedSpeed SummarizeSustained(std::vector<SustainedRound> rounds, double seconds);

}  // namespace skywave
