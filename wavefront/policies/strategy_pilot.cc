#include "wavefront/policies/strategy_pilot.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "lights/strategies/visibility.h"
#include "wavefront/integrator.h"
#include "wavefront/paths/pilot.h"
#include "wavefront/policies/visibility_pilot.h"
#include "wavefront/policy.h"

namespace skywave {
namespace {

// Pixels of the pilot get this many samples, or more in small films, from each of two seeds.
// Variances are those of their means, since strategies differ in how much they gain by stratified
// samples.
constexpr std::uint32_t kSamples = 16;
// They turn a frame's seed into those of the pilot, which are not that of the pilot that teaches:
// what was learnt from samples looks too good when judged by the same samples.
constexpr std::uint32_t kChoiceSeeds[] = {0xA370C401u, 0x51B3E9D7u};
// A candidate other than the first has to be better by this factor, or the noise of the pilot would
// decide between equal ones.
constexpr double kClearly = 0.9;
// What a sample costs besides its rays [rays]: generation, shading, the film.
constexpr double kCostOfSample = 1;

// What one candidate has cost in the pilot.
struct Work {
  std::uint64_t rays = 0, light_samples = 0;
};

Work WorkOf(const RenderStats& stats) {
  return {.rays = stats.total_rays(),
          .light_samples = stats.lanes[std::uint32_t(Kernel::kLightSample)].active};
}

// Renders the pilot and returns its picture.
Image RenderPilot(const FrameView& pilot, float brightest, WorkerPool& pool, Work& work) {
  // The threads share no pixel: they take a tile each.
  constexpr std::uint32_t kSide = 16;
  static_assert(kSide % kBeamWidth == 0 && kSide % kBeamHeight == 0);
  const std::uint32_t width = pilot.camera.width, height = pilot.camera.height;
  const std::uint32_t across = (width + kSide - 1) / kSide, down = (height + kSide - 1) / kSide;
  const std::uint32_t samples = pilot.options.samples_per_pixel;
  Film film(int(width), int(height), brightest);
  std::vector<Work> of_tile(std::size_t(across) * down);
  pool.ForEach(of_tile.size(), [&](std::size_t i, Worker& worker, RayRecorder*) {
    const std::uint32_t x = std::uint32_t(i) % across * kSide,
                        y = std::uint32_t(i) / across * kSide;
    const Tile tile = {x, y, std::min(kSide, width - x), std::min(kSide, height - y)};
    const std::uint64_t rows = std::uint64_t(tile.width) * tile.height * samples;
    const RenderStats before = std::exchange(worker.stats, {});
    for (std::uint64_t first = 0; first < rows; first += pilot.options.wave) {
      const auto count = std::uint32_t(std::min<std::uint64_t>(pilot.options.wave, rows - first));
      Describe(pilot.options.integrator)
          .render_wave(pilot, {.tile = tile, .first = first, .count = count}, worker, film);
    }
    of_tile[i] = WorkOf(std::exchange(worker.stats, before));
  });
  for (const Work& of_one : of_tile) {
    work.rays += of_one.rays, work.light_samples += of_one.light_samples;
  }
  return film.Resolve(std::uint64_t{samples});
}

// Returns the variance of the mean of two pictures of one scene, relative to its squared mean.
double RelativeVariance(const Image& a, const Image& b) {
  double squares = 0, sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    const double difference = double(a.rgb[i]) - double(b.rgb[i]);
    squares += difference * difference, sum += double(a.rgb[i]) + double(b.rgb[i]);
  }
  // The variance of the mean is a quarter of the mean squared difference.
  return sum > 0 ? squares * double(a.rgb.size()) / (sum * sum) : 0;
}

}  // namespace

std::unique_ptr<EnvStrategy> ChooseStrategy(StrategySlot slot, float brightest_radiance,
                                            WorkerPool& pool, FrameView& frame,
                                            std::vector<StrategyChoice>& choices,
                                            PilotCounts& visibility) {
  const std::span<const StrategyCandidate> candidates = (frame.*slot)->candidates();
  frame.*slot = candidates[0].strategy;
  // Light paths start with samples of their own.
  if (Describe(frame.options.integrator).has_light_paths() || !frame.has_environment()) {
    return nullptr;
  }
  const auto start = Clock::now();
  FrameView pilot = CoarseView(frame, PilotShare(frame), std::size(kChoiceSeeds) * kSamples);
  pilot.Show<ControlView>(nullptr);
  pilot.options.samples_per_pixel /= std::size(kChoiceSeeds);
  const double samples = double(PilotPaths(pilot)) * std::size(kChoiceSeeds);
  StrategyChoice choice;
  std::unique_ptr<EnvStrategy> best_taught;
  double best = 0;
  for (const StrategyCandidate& candidate : candidates) {
    PilotCounts counts;
    std::unique_ptr<VisibilityStrategy> taught =
        LearnVisibility(frame, *candidate.strategy, pool, counts);
    // A strategy that has learnt nothing draws as `importance` does.
    if (taught && taught->learnt() == 0) continue;
    pilot.*slot = taught ? taught.get() : candidate.strategy;
    Work work;
    Image pictures[std::size(kChoiceSeeds)];
    for (std::size_t i = 0; i < std::size(kChoiceSeeds); ++i) {
      pilot.options.seed = frame.options.seed ^ kChoiceSeeds[i];
      pictures[i] = RenderPilot(pilot, brightest_radiance, pool, work);
    }
    const CandidateScore score = {
        .name = std::string(candidate.strategy->name()),
        .variance = RelativeVariance(pictures[0], pictures[1]),
        .cost = kCostOfSample +
                (double(work.rays) + candidate.cost * double(work.light_samples)) / samples};
    const bool first = choice.scores.empty();
    choice.scores.push_back(score);
    const double product = score.variance * score.cost * (first ? kClearly : 1);
    if (!first && !(product < best)) continue;
    best = product, best_taught = std::move(taught);
    // Of what the frame has.
    counts.policy = visibility.policy, counts.found = visibility.found;
    visibility = counts;
    frame.*slot = best_taught ? best_taught.get() : candidate.strategy;
    choice.chosen = score.name;
  }
  choice.seconds = SecondsSince(start);
  choices.push_back(std::move(choice));
  return best_taught;
}

namespace {

// Has a pilot choose or teach the strategy `slot` of the frame, if it needs that. Returns what was
// taught, which the frame then uses.
std::unique_ptr<EnvStrategy> Prepare(StrategySlot slot, const Pilots& pilots, PilotCounts& counts,
                                     FrameView& frame) {
  if (frame.*slot == nullptr) return nullptr;
  std::unique_ptr<EnvStrategy> taught;
  if ((frame.*slot)->candidates().empty()) {
    taught = LearnVisibility(frame, *(frame.*slot), pilots.pool, counts);
  } else {
    taught = ChooseStrategy(slot, pilots.brightest_radiance, pilots.pool, frame,
                            pilots.reports.choices, counts);
  }
  if (taught) frame.*slot = taught.get();
  return taught;
}

std::shared_ptr<const void> Teach(FrameView& frame, const Pilots& pilots) {
  auto taught = std::make_shared<std::array<std::unique_ptr<EnvStrategy>, 2>>();
  PilotCounts counts = {.policy = "visibility", .found = "rays"};
  (*taught)[0] = Prepare(&FrameView::strategy, pilots, counts, frame);
  (*taught)[1] = Prepare(&FrameView::continuation_strategy, pilots, counts, frame);
  if (counts.paths > 0) pilots.reports.counts.push_back(counts);
  return taught;
}

}  // namespace

PolicyDescriptor StrategyPolicy() { return {.teach = Teach}; }

}  // namespace skywave
