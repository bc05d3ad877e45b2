#include "wavefront/photon_pass.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "wavefront/flush_denormals.h"
#include "wavefront/integrator.h"
#include "wavefront/photon_stages.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

using Clock = std::chrono::steady_clock;

// Light paths that are traced before anybody looks how full the maps are.
constexpr std::uint64_t kLeastRound = 1 << 14, kMostRound = 1 << 18;

// The light paths by which merging is planned are no pass's: samples of a pixel end before.
constexpr std::uint64_t kPlanningPaths = std::uint64_t{0xFFFFFFFF} << 32;

// A map before it is built: photons in the order of light paths, and how many of these they are of.
struct Harvest {
  std::uint64_t wanted;
  std::vector<Photon> photons;
  std::vector<PhotonSubpath> subpaths;
  std::uint64_t light_paths = 0;

  bool full() const { return photons.size() >= wanted; }
  std::uint64_t missing() const { return full() ? 0 : wanted - photons.size(); }

  // Takes the photons of light paths [first, first + count), up to the path that fills the map.
  void Take(const PhotonList& list, std::uint64_t first, std::uint64_t count) {
    if (full()) return;
    std::size_t end = std::min<std::size_t>(list.photons.size(), wanted - photons.size());
    while (end > 0 && end < list.photons.size() && list.path[end] == list.path[end - 1]) ++end;
    const auto take = [end](const auto& from, auto& to) {
      to.insert(to.end(), from.begin(), from.begin() + std::ptrdiff_t(std::min(end, from.size())));
    };
    take(list.photons, photons), take(list.subpath, subpaths);
    light_paths = full() ? first + list.path[end - 1] + 1 : first + count;
  }
};

// The strategy of camera paths may want many light samples or surfaces to draw them for.
FrameView LightPathView(const FrameView& frame) {
  FrameView view = frame;
  view.strategy = frame.emitter;
  view.options.light_samples = 1;
  return view;
}

// The map has mirrors or glass for light to come from.
bool HasCaustics(const Geometry& geometry) { return (geometry.bsdfs() >> kFirstDeltaBsdf) != 0; }

// The largest distance of a lookup where the user gives none. A search for the nearest ends by
// itself where there are photons, so it is for the places where there are few.
float ChooseRadius(const PhotonMap& map, const PhotonOptions& options) {
  constexpr float kSearch = 3;
  if (options.distance > 0) return options.distance;
  return map.TypicalDistance(options.neighbors) * (options.progressive() ? 1 : kSearch);
}

// What a pass is to store, and of which light paths of the frame.
struct Goal {
  std::uint64_t first;              // number of the first light path
  std::uint64_t most;               // light paths
  std::uint64_t caustic, indirect;  // photons; after the path that brings the last one it is done
};

// Traces light paths until both maps are full. Radii are left open.
PhotonMaps TraceMaps(const FrameView& frame, const Goal& goal,
                     std::vector<std::unique_ptr<Worker>>& workers,
                     std::vector<RayRecorder>* recorders) {
  const FrameView lit = LightPathView(frame);
  const std::uint32_t wave = frame.options.wave;
  Harvest caustic = {.wanted = goal.caustic, .photons = {}, .subpaths = {}};
  Harvest indirect = {.wanted = goal.indirect, .photons = {}, .subpaths = {}};
  std::vector<PhotonLists> waves;
  for (std::uint64_t traced = 0; traced < goal.most && !(caustic.full() && indirect.full());) {
    const std::uint64_t missing = std::max(caustic.missing(), indirect.missing());
    const std::uint64_t round =
        std::min(std::clamp(missing, kLeastRound, kMostRound), goal.most - traced);
    const PhotonWishes wishes = {.caustic = !caustic.full(),
                                 .indirect = !indirect.full(),
                                 .all_light = frame.options.photons.gather > 0};
    waves.assign((round + wave - 1) / wave, {});
    tbb::parallel_for(std::size_t{0}, waves.size(), [&](std::size_t i) {
      const FlushDenormals flush;
      const std::size_t slot = OwnWorker(frame.options, workers);
      FrameView view = lit;
      view.tracer.recorder = recorders != nullptr ? &(*recorders)[slot] : nullptr;
      const std::uint64_t first = traced + i * wave;
      const auto count = std::uint32_t(std::min<std::uint64_t>(wave, traced + round - first));
      if (frame.options.integrator == Integrator::kVcm) {
        TraceVertexWave(view, goal.first + first, count, *workers[slot], waves[i].indirect);
      } else {
        TracePhotonWave(view, goal.first + first, count, wishes, *workers[slot], waves[i]);
      }
    });
    for (std::size_t i = 0; i < waves.size(); ++i) {
      const std::uint64_t first = traced + i * wave;
      const std::uint64_t count = std::min<std::uint64_t>(wave, traced + round - first);
      caustic.Take(waves[i].caustic, first, count);
      indirect.Take(waves[i].indirect, first, count);
    }
    traced += round;
  }
  PhotonMaps maps;
  maps.caustic = PhotonMap(caustic.photons, caustic.light_paths);
  caustic = {};
  maps.indirect = PhotonMap(indirect.photons, indirect.light_paths, indirect.subpaths);
  return maps;
}

// Where the light paths of a pass begin that has its own.
std::uint64_t FirstOf(const PhotonPass& pass) { return std::uint64_t(pass.first_sample) << 32; }

// What all passes of vertex connection and merging have in common: weights need to know beforehand
// how many light paths there will be and within which distance their vertices are merged.
struct MergePlan {
  std::uint64_t light_paths;  // of a pass
  float radius;               // of the first pass
};

// Found out by light paths that are not used otherwise.
MergePlan PlanMerging(const FrameView& frame, std::vector<std::unique_ptr<Worker>>& workers,
                      std::vector<RayRecorder>* recorders) {
  const RenderOptions& options = frame.options;
  const PhotonOptions& wish = options.photons;
  const std::uint64_t samples = options.samples_per_pixel / PhotonPasses(options).size();
  const Goal goal = {.first = kPlanningPaths,
                     .most = options.max_depth > 0 ? frame.light_paths() * samples : 0,
                     .caustic = 0,
                     .indirect = wish.indirect};
  const PhotonMaps maps = TraceMaps(frame, goal, workers, recorders);
  return {
      .light_paths = maps.indirect.light_paths(),
      .radius = wish.distance > 0 ? wish.distance : maps.indirect.TypicalDistance(wish.neighbors)};
}

// WayPolicy::merged of a pass whose radius is `shrink` of the first one's.
float MergedArea(const MergePlan& plan, float shrink) {
  const float radius = plan.radius * shrink;
  return std::numbers::pi_v<float> * radius * radius * float(plan.light_paths);
}

// The vertices of the light paths of a pass; none if nothing is merged. `frame` has the area merged
// of the pass.
PhotonMaps TraceVertices(const FrameView& frame, const MergePlan& plan, const PhotonPass& pass,
                         std::vector<std::unique_ptr<Worker>>& workers,
                         std::vector<RayRecorder>* recorders) {
  const Goal goal = {.first = FirstOf(pass),
                     .most = frame.merged > 0 ? plan.light_paths : 0,
                     .caustic = 0,
                     .indirect = ~std::uint64_t{0}};
  return TraceMaps(frame, goal, workers, recorders);
}

}  // namespace

void PhotonCounts::Add(const PhotonMaps& maps, double pass_seconds) {
  caustic += maps.caustic.size(), indirect += maps.indirect.size();
  light_paths += std::max(maps.caustic.light_paths(), maps.indirect.light_paths());
  bytes = std::max(bytes, maps.caustic.bytes() + maps.indirect.bytes());
  radius = maps.indirect.radius, caustic_radius = maps.caustic.radius;
  seconds += pass_seconds;
}

std::vector<PhotonPass> PhotonPasses(const RenderOptions& options) {
  const std::uint32_t samples = options.samples_per_pixel, wanted = options.photons.passes;
  const bool each_sample = options.integrator == Integrator::kVcm && wanted == 0;
  const std::uint32_t passes = each_sample ? samples : std::clamp(wanted, 1u, samples);
  const auto first_of = [&](std::uint32_t pass) {
    return std::uint32_t(std::uint64_t(samples) * pass / passes);
  };
  std::vector<PhotonPass> list;
  double shrink2 = 1;
  const auto shrink = [&](std::uint32_t pass) {
    shrink2 *= (pass + 1 + double(options.photons.alpha)) / (pass + 2);
  };
  // Where a pass is a sample, the passes of a range of samples are those of the whole.
  if (each_sample) {
    for (std::uint32_t i = 0; i < options.first_sample; ++i) shrink(i);
  }
  const std::uint32_t before = each_sample ? options.first_sample : 0;
  for (std::uint32_t i = 0; i < passes; ++i) {
    list.push_back({.first_sample = options.first_sample + first_of(i),
                    .samples = first_of(i + 1) - first_of(i),
                    .shrink = float(std::sqrt(shrink2))});
    shrink(before + i);
  }
  return list;
}

PhotonMaps TracePhotons(const FrameView& frame, const PhotonPass& pass,
                        std::vector<std::unique_ptr<Worker>>& workers,
                        std::vector<RayRecorder>* recorders) {
  const PhotonOptions& wish = frame.options.photons;
  // One set of photons for all samples, whichever of them are rendered, or one for each pass.
  Goal goal = {.first = wish.progressive() ? FirstOf(pass) : 0,
               .most = 0,
               .caustic = HasCaustics(*frame.geometry) ? wish.caustic : 0,
               .indirect = wish.indirect};
  // A photon that is no direct light at the surface that is seen has met one before.
  if (frame.options.max_depth < 2) goal.caustic = goal.indirect = 0;
  goal.most = kMostPathsAPhoton * std::max(goal.caustic, goal.indirect);
  PhotonMaps maps = TraceMaps(frame, goal, workers, recorders);
  for (PhotonMap* const map : {&maps.caustic, &maps.indirect}) {
    map->radius = ChooseRadius(*map, wish);
  }
  return maps;
}

void ForEachPass(const FrameView& frame, std::vector<std::unique_ptr<Worker>>& workers,
                 std::vector<RayRecorder>* recorders, PhotonCounts& counts,
                 const std::function<void(const FrameView&)>& render) {
  const bool merges = frame.options.integrator == Integrator::kVcm;
  const MergePlan plan = merges ? PlanMerging(frame, workers, recorders) : MergePlan{};
  float caustic_radius = 0, indirect_radius = plan.radius;  // of the first pass
  for (const PhotonPass& pass : PhotonPasses(frame.options)) {
    const auto start = Clock::now();
    FrameView view = frame;
    view.options.first_sample = pass.first_sample;
    view.options.samples_per_pixel = pass.samples;
    PhotonMaps maps;
    if (merges) {
      view.merged = MergedArea(plan, pass.shrink);
      maps = TraceVertices(view, plan, pass, workers, recorders);
    } else {
      maps = TracePhotons(frame, pass, workers, recorders);
      if (caustic_radius == 0) caustic_radius = maps.caustic.radius;
      if (indirect_radius == 0) indirect_radius = maps.indirect.radius;
    }
    maps.caustic.radius = caustic_radius * pass.shrink;
    maps.indirect.radius = indirect_radius * pass.shrink;
    counts.Add(maps, std::chrono::duration<double>(Clock::now() - start).count());
    view.photons = &maps;
    render(view);
  }
}

}  // namespace skywave
