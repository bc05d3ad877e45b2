#include "bench/measure/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace skywave {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr int kResamples = 2000;

std::vector<double> Pick(const std::vector<double>& values, const std::vector<std::size_t>& drawn) {
  std::vector<double> picked;
  for (std::size_t index : drawn) picked.push_back(values[index]);
  return picked;
}

// Every rung has its own draw because measurements at different times are independent.
CurveRuns Resample(const CurveRuns& runs, const std::vector<std::vector<std::size_t>>& draws) {
  CurveRuns resampled;
  for (std::size_t rung = 0; rung < runs.seconds.size(); ++rung) {
    resampled.seconds.push_back(Pick(runs.seconds[rung], draws[rung]));
    resampled.errors.push_back(Pick(runs.errors[rung], draws[rung]));
  }
  return resampled;
}

double TargetOf(const std::vector<CurvePoint>& first, std::optional<double> target) {
  return target ? *target : first.back().y;
}

double Bound(const Crossing& crossing) {
  if (crossing.kind == Crossing::kBefore) return 0;
  return crossing.kind == Crossing::kBeyond ? kInfinity : crossing.x;
}

double SpeedUp(const Crossing& first, const Crossing& other) {
  const bool known = first.kind == Crossing::kInside && other.kind == Crossing::kInside;
  return known ? first.x / other.x : kUnknown;
}

Interval MiddleOf(std::vector<double> values) {
  if (std::any_of(values.begin(), values.end(), [](double v) { return std::isnan(v); })) {
    return {kUnknown, kUnknown};
  }
  std::sort(values.begin(), values.end());
  // Values are not interpolated because a neighbour may be infinite.
  const auto at = [&](double p) {
    return values[std::size_t(std::lround(p * double(values.size() - 1)))];
  };
  return {at(0.025), at(0.975)};
}

}  // namespace

CurveRuns MakeCurveRuns(const Contestant& contestant, ErrorMeasure measure) {
  CurveRuns runs;
  for (const Rung& rung : contestant.ladder) {
    runs.seconds.push_back(rung.seconds());
    runs.errors.push_back(rung.errors(measure));
  }
  return runs;
}

std::vector<CurvePoint> Curve(const CurveRuns& runs) {
  std::vector<CurvePoint> curve;
  for (std::size_t rung = 0; rung < runs.seconds.size(); ++rung) {
    curve.push_back({Median(runs.seconds[rung]), Mean(runs.errors[rung])});
  }
  return curve;
}

TargetSummary SummarizeTarget(const std::vector<CurveRuns>& curves, std::optional<double> target) {
  const std::vector<CurvePoint> first = Curve(curves.front());
  TargetSummary summary = {
      .target = TargetOf(first, target), .from_first = !target.has_value(), .times = {}};
  const Crossing first_time = FindCrossing(first, summary.target);
  for (const CurveRuns& runs : curves) {
    const Crossing time = FindCrossing(Curve(runs), summary.target);
    summary.times.push_back({.time = time,
                             .interval = {kUnknown, kUnknown},
                             .speed_up = SpeedUp(first_time, time),
                             .speed_up_interval = {kUnknown, kUnknown}});
  }

  const std::size_t repeats = curves.front().seconds.front().size();
  if (repeats < 2) return summary;
  std::size_t rungs = 0;
  for (const CurveRuns& runs : curves) rungs = std::max(rungs, runs.seconds.size());
  std::vector<std::vector<double>> times(curves.size()), speed_ups(curves.size());
  std::mt19937 random;  // the default seed gives the same draws every time
  for (int i = 0; i < kResamples; ++i) {
    std::vector<std::vector<std::size_t>> draws(rungs, std::vector<std::size_t>(repeats));
    for (auto& draw : draws) {
      for (std::size_t& index : draw) index = random() % repeats;
    }
    const std::vector<CurvePoint> leader = Curve(Resample(curves.front(), draws));
    const double level = TargetOf(leader, target);
    const Crossing leader_time = FindCrossing(leader, level);
    for (std::size_t c = 0; c < curves.size(); ++c) {
      const Crossing time = FindCrossing(Curve(Resample(curves[c], draws)), level);
      times[c].push_back(Bound(time));
      speed_ups[c].push_back(SpeedUp(leader_time, time));
    }
  }
  for (std::size_t c = 0; c < curves.size(); ++c) {
    summary.times[c].interval = MiddleOf(times[c]);
    summary.times[c].speed_up_interval = MiddleOf(speed_ups[c]);
  }
  return summary;
}

}  // namespace skywave
