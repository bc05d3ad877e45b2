// A pilot is a coarse render before a frame: its camera paths learn what the frame needs to know.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/partition.h"
#include "lights/tables/places.h"
#include "wavefront/frame.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Pilots have so many paths, few against a usual render, unless they grow with the picture.
inline constexpr std::uint64_t kMostPilotPaths = 1 << 17;

// Returns the frame as a pilot sees it: the whole film, coarse, with about `paths` paths and at
// least `samples` of each pixel. It depends on neither threads nor wave, nor on which part of the
// film or which samples the frame has.
FrameView CoarseView(const FrameView& frame, std::uint64_t paths, std::uint32_t samples);

// Returns the frame of the pilot that teaches: the whole film, coarse, by path tracing with light
// samples of `strategy`, with random numbers of its own.
FrameView PilotView(const FrameView& frame, const EnvStrategy& strategy,
                    std::uint64_t paths = kMostPilotPaths);
// Returns how many paths a pilot has that grows with the picture, within these limits.
std::uint64_t PilotShare(const FrameView& frame, std::uint64_t least = 1 << 12,
                         std::uint64_t most = kMostPilotPaths);

// Returns the cube in which the places of a scene lie, of side 0 if there are none.
PlaceBox PlaceBoxOf(const SceneSphere& sphere);

// Returns all its pixels as one tile, and the number of its paths.
Tile PilotTile(const FrameView& pilot);
std::uint64_t PilotPaths(const FrameView& pilot);

inline double Luminance(float r, float g, float b) {
  return double(kLuminance[0]) * r + double(kLuminance[1]) * g + double(kLuminance[2]) * b;
}

// Follows paths `range` of the pilot, and shows an observer
//   SeeRays(w, rays, n)        rays that left the surfaces at hand, with their hits in w.hits
//   SeeEscapes(w, n)           those of them that hit nothing, in w.escaped
//   SeeLightSamples(w, n)      the surfaces at hand that have a density, and their light samples in
//                              w.lights, traced: occluded ones have a negative reach
template <class Observer>
void FollowPilotPaths(const FrameView& pilot, const WaveRange& range, Worker& w,
                      Observer& observer) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(pilot, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  std::uint32_t n = range.count;
  for (std::uint32_t bounce = 0; n > 0; ++bounce) {
    SortedHits sorted =
        TraceAndSort(pilot, kCameraEnd, *rays, n, bounce, /*only_delta=*/false, w, clock);
    if (bounce > 0) observer.SeeRays(w, *rays, n);
    MoveEscaped(*rays, sorted.queues->queue, n, w.escaped);
    if (bounce > 0 && sorted.escaped > 0) observer.SeeEscapes(w, sorted.escaped);
    if (bounce == pilot.options.max_depth) break;
    PrepareHits(pilot, kCameraEnd, *rays, n, std::move(sorted), w, clock);
    LightSurfaces(pilot, bounce, w, clock);
    observer.SeeLightSamples(w, w.ranges.light_sampled());
    n = Scatter(pilot, Points(pilot, w), {kCameraEnd, bounce}, w.scratch, *next,
                ControlsOf(pilot, w));
    std::swap(rays, next);
  }
}

// Follows camera paths `range` through surfaces of the kinds from `first_kind` on, and calls
// see(length) whenever w.surfaces holds surfaces of all kinds, no more than `most` of a path:
// length[i] is that of path i so far.
template <class See>
void FollowToSurfaces(const FrameView& pilot, const WaveRange& range, std::uint32_t first_kind,
                      std::uint32_t most, Worker& w, const See& see) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(pilot, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  std::vector<float> length(range.count, 0.0f);
  std::uint32_t n = range.count;
  for (std::uint32_t bounce = 0; n > 0 && bounce < most; ++bounce) {
    PrepareHits(pilot, kCameraEnd, *rays, n,
                TraceAndSort(pilot, kCameraEnd, *rays, n, bounce, /*only_delta=*/false, w, clock),
                w, clock);
    const SurfaceColumns& s = w.surfaces;
    for (std::uint32_t i = 0; i < w.ranges.total(); ++i) length[s.path[i]] += s.t[i];
    see(length);
    n = Scatter(pilot, Points(pilot, w), {kCameraEnd, bounce, first_kind}, w.scratch, *next);
    std::swap(rays, next);
  }
}

// Calls trace(range, worker, found) for all paths of the pilot, wave by wave, and returns all that
// it has appended to `found`. Statistics of the workers stay as they are.
template <class Found, class Trace>
std::vector<Found> TracePilot(const FrameView& pilot, WorkerPool& pool, const Trace& trace) {
  const Tile tile = PilotTile(pilot);
  const std::uint64_t total = PilotPaths(pilot);
  const std::uint64_t wave = pilot.options.wave;
  std::vector<std::vector<Found>> waves((total + wave - 1) / wave);
  pool.ForEach(waves.size(), [&](std::size_t i, Worker& worker, RayRecorder*) {
    const RenderStats stats = worker.stats;
    const WaveRange range = {
        .tile = tile,
        .first = i * wave,
        .count = std::uint32_t(std::min<std::uint64_t>(wave, total - i * wave))};
    trace(range, worker, waves[i]);
    worker.stats = stats;
  });
  std::vector<Found> all;
  for (const std::vector<Found>& found : waves) all.insert(all.end(), found.begin(), found.end());
  return all;
}

}  // namespace skywave
