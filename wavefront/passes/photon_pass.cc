#include "wavefront/passes/photon_pass.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "base/clock.h"
#include "wavefront/passes/photon_collector.h"
#include "wavefront/paths/light_paths.h"
#include "wavefront/stages/photon_stages.h"

namespace skywave {
namespace {

// Traces light paths [first, first + count) of the frame and stores them at surfaces with a density
// in the lists that `wanted` names, in the order (path, surface).
void TracePhotonWave(const FrameView& frame, std::uint64_t first, std::uint32_t count,
                     const WantedPhotons& wanted, Worker& w, PhotonLists& lists) {
  StageClock clock(w.stats);
  std::fill_n(w.history->met, count, 0u);
  // Paths that can only make caustics end at the first surface with a density.
  const std::uint32_t first_kind = wanted.indirect ? 0 : kFirstDeltaBsdf;
  FollowLightPaths(frame, first, count, first_kind, frame.options.max_depth, w, clock,
                   [&](std::uint32_t bounce) { StorePhotons(wanted, bounce, w, lists, clock); });
  lists.caustic.SortByPath(count);
  lists.indirect.SortByPath(count);
  clock.Lap(Stage::kPhotons);
}

// Chooses the largest distance of a lookup: the user's, or one by the map. A search for the nearest
// ends by itself where there are photons, so this is for the places where there are few.
void ChooseRadius(const PhotonOptions& options, PhotonMap& map) {
  constexpr float kSearch = 3;
  const float usual = map.TypicalDistance(options.neighbors);
  const float largest = options.progressive() ? usual : kSearch * usual;
  map.radius = options.distance > 0 ? options.distance : largest;
  map.near = options.progressive() ? map.radius : std::min(usual, map.radius);
}

}  // namespace

void PhotonCounts::Add(const PhotonMaps& maps, double pass_seconds) {
  caustic += maps.caustic.size(), indirect += maps.indirect.size();
  light_paths += std::max(maps.caustic.light_paths(), maps.indirect.light_paths());
  bytes = std::max(bytes, maps.caustic.bytes() + maps.indirect.bytes());
  radius = maps.indirect.radius, caustic_radius = maps.caustic.radius;
  seconds += pass_seconds;
}

PhotonMaps TracePhotons(const FrameView& frame, const PhotonPass& pass, WorkerPool& pool) {
  const auto& photons = frame.options.of<PhotonOptions>();
  const std::uint32_t max_depth = frame.options.max_depth;
  // There is one set of photons for all samples, whichever of them are rendered, or one for each
  // pass.
  const std::uint64_t first = photons.progressive() ? std::uint64_t(pass.samples.first) << 32 : 0;
  // A photon that is not direct light at the visible surface has hit another one before.
  const bool any = max_depth >= 2;
  PhotonCollector caustic(any && frame.geometry->has_deltas() ? photons.caustic : 0, max_depth,
                          false);
  PhotonCollector indirect(any ? photons.indirect : 0, max_depth, false);
  const auto trace = [&](const FrameView& view, std::uint64_t number, std::uint32_t count,
                         Worker& worker, PhotonLists& lists) {
    const WantedPhotons wanted = {
        .caustic = !caustic.full(), .indirect = !indirect.full(), .all_light = photons.gather > 0};
    TracePhotonWave(view, number, count, wanted, worker, lists);
  };
  CollectPhotons(LightPathView(frame), first,
                 kMostPathsAPhoton * std::max(caustic.wanted(), indirect.wanted()), trace, caustic,
                 indirect, pool);
  PhotonMaps maps;
  const auto build = [&photons](PhotonCollector& collected, PhotonMap& map) {
    map = PhotonMap(collected.photons(), collected.light_paths());
    ChooseRadius(photons, map);
    collected = {};
  };
  tbb::parallel_invoke([&] { build(caustic, maps.caustic); },
                       [&] { build(indirect, maps.indirect); });
  return maps;
}

std::string DescribePhotons(const PhotonCounts& counts) {
  return fmt::format(
      "photons: {} indirect, {} caustic of {} light paths in {:.3f} s, maps of {:.1f} MiB, radii "
      "{:.4g} and {:.4g}",
      counts.indirect, counts.caustic, counts.light_paths, counts.seconds,
      double(counts.bytes) / (1 << 20), counts.radius, counts.caustic_radius);
}

void ForEachPhotonPass(const FrameView& frame, const TracePass& trace, PhotonCounts& counts,
                       const RenderPass& render) try {
  const SampleRange wanted = SamplesOf(frame.options);
  for (const PhotonPass& pass : PhotonPasses(frame.options)) {
    const SampleRange samples = {std::max(pass.samples.first, wanted.first),
                                 std::min(pass.samples.end, wanted.end)};
    if (samples.first >= samples.end) continue;
    const auto start = Clock::now();
    FrameView view = frame;
    const PhotonMaps maps = trace(view, pass);
    counts.Add(maps, SecondsSince(start));
    view.Show(&maps);
    view.options.first_sample = samples.first;
    view.options.samples_per_pixel = samples.count();
    if (!render(view)) return;
  }
} catch (const std::bad_alloc&) {
  // Nothing else takes as much memory, whatever allocation failed.
  RefusePhotons(frame.options, "there is no memory left for so many");
}

}  // namespace skywave
