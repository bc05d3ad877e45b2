#include "bench/measure/sustain.h"

#include <algorithm>
#include <limits>

#include "base/clock.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

std::vector<CurvePoint> BlocksOf(const std::vector<SustainedRound>& rounds, double seconds) {
  const int count = std::clamp(int(rounds.size()) / 2, 1, kSustainBlocks);
  std::vector<std::vector<double>> rates(static_cast<std::size_t>(count));
  for (const SustainedRound& round : rounds) {
    const auto block = std::size_t(double(count) * round.start / seconds);
    rates[std::min(block, rates.size() - 1)].push_back(round.rate);
  }
  std::vector<CurvePoint> blocks;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    if (rates[i].empty()) continue;  // one round has taken longer than a block
    blocks.push_back({(double(i) + 0.5) * seconds / double(count), Mean(rates[i])});
  }
  return blocks;
}

std::vector<double> RatesOf(std::span<const CurvePoint> blocks) {
  std::vector<double> rates;
  for (const CurvePoint& block : blocks) rates.push_back(block.y);
  return rates;
}

}  // namespace

SustainedSpeed MeasureSustained(std::span<const RenderJob* const> jobs, double seconds,
                                const std::function<void(double done)>& show) {
  std::vector<SustainedRound> rounds;
  const auto begin = Clock::now();
  double now = 0;
  while (now < seconds) {
    std::vector<double> rates;
    for (const RenderJob* const job : jobs) {
      Film film = job->MakeFilm();
      const FrameResult frame = RenderFrame(job->frame(), film);
      rates.push_back(double(frame.stats.samples) / frame.seconds);
    }
    rounds.push_back({.start = now, .rate = GeometricMean(rates)});
    now = SecondsSince(begin);
    show(std::min(now / seconds, 1.0));
  }
  return SummarizeSustained(std::move(rounds), now);
}

SustainedSpeed SummarizeSustained(std::vector<SustainedRound> rounds, double seconds) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  SustainedSpeed speed = {.seconds = seconds,
                          .rounds = std::move(rounds),
                          .blocks = {},
                          .last_to_first = {},
                          .drift_per_minute = {kNone, {kNone, kNone}}};
  speed.blocks = BlocksOf(speed.rounds, seconds);
  const std::span<const CurvePoint> blocks = speed.blocks;
  const std::size_t quarter = std::max<std::size_t>(blocks.size() / 4, 1);
  const std::vector<double> first[] = {RatesOf(blocks.first(quarter))};
  const std::vector<double> last[] = {RatesOf(blocks.last(quarter))};
  speed.first = Mean(first[0]);
  speed.last = Mean(last[0]);
  speed.last_to_first = WelchRatio(first, last);
  if (blocks.size() < 2) return speed;
  const double mean = Mean(RatesOf(blocks));
  std::vector<CurvePoint> relative;
  for (const CurvePoint& block : blocks) relative.push_back({block.x / 60, block.y / mean});
  speed.drift_per_minute = FitSlope(relative);
  return speed;
}

}  // namespace skywave
