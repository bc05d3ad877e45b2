#include "wavefront/integrator.h"

#include <algorithm>
#include <utility>

#include "kernels/accumulate.h"
#include "kernels/partition.h"
#include "kernels/sampler.h"
#include "kernels/surface.h"
#include "wavefront/checks.h"

namespace skywave {
namespace {

void CountRays(RenderStats& stats, std::uint32_t bounce, std::uint32_t n, std::uint32_t wave) {
  stats.rays[std::uint32_t(bounce == 0 ? RayKind::kCamera : RayKind::kBounce)] += n;
  BounceOccupancy& occupancy = stats.bounces[std::min(bounce, kCountedBounces - 1)];
  occupancy.rows += n;
  occupancy.capacity += wave;
}

void CountShadowRays(RenderStats& stats, const LightColumns& lights, std::uint32_t n) {
  std::uint64_t open = 0;
  for (std::uint32_t i = 0; i < n; ++i) open += lights.t_far[i] >= 0;
  stats.rays[std::uint32_t(RayKind::kShadow)] += open;
}

// The surfaces of the bounce at hand, as strategies see them.
ShadePoints Points(const FrameView& frame, const Worker& w) {
  return {.surfaces = w.surfaces,
          .ranges = w.ranges,
          .materials = frame.geometry->materials(),
          .paths = w.paths};
}

// The keys of the rays that arrive at a bounce.
const std::uint32_t* PathRayKeys(const FrameView& frame, std::uint32_t bounce,
                                 const RayColumns& rays, std::uint32_t n, const Worker& w) {
  return RayKeys(frame, w.paths, rays.path, n, SamplePair(bounce, SampleUse::kScatter),
                 w.queue->queue);
}

// Traces rays [0, n), adds what the escaped ones see, and makes surfaces to shade of the hits.
void MeetSurfaces(const FrameView& frame, std::uint32_t bounce, const RayColumns& rays,
                  std::uint32_t n, bool only_delta, Worker& w, StageClock& clock) {
  const MaterialView materials = frame.geometry->materials();
  SurfaceRanges ranges;
  TraceClosest(frame.tracer, rays, n, w.hits, PathRayKeys(frame, bounce, rays, n, w));
  clock.Lap(Stage::kIntersect);
  const std::uint32_t escaped =
      SortHits(*frame.geometry, rays, w.hits, n, only_delta, w.queue->queue, ranges);
  MoveEscaped(rays, w.queue->queue, n, w.escaped);
  clock.Lap(Stage::kPartition);
  // Before the surfaces that the rays left are overwritten: strategies may ask for them.
  AddEscaped(frame, Points(frame, w), w.escaped, escaped, w.paths);
  clock.Lap(Stage::kEscape);
  w.ranges = ranges;
  MoveSurfaces(rays, w.hits, w.queue->queue, n, ranges, w.surfaces);
  clock.Lap(Stage::kPartition);
  PrepareSurfaces(frame.geometry->triangles(), materials.records, ranges.total(), w.surfaces);
  TextureSurfaces(frame, ranges, w.surfaces);
  CheckSurfaces(w.surfaces, ranges.total());
  clock.Lap(Stage::kSurface);
}

// The end of a path: only what lies beyond the scene can still be seen.
void MeetSky(const FrameView& frame, std::uint32_t bounce, const RayColumns& rays, std::uint32_t n,
             Worker& w, StageClock& clock) {
  TraceEscapes(frame.tracer, rays, n, w.hits, PathRayKeys(frame, bounce, rays, n, w));
  clock.Lap(Stage::kIntersect);
  const std::uint32_t escaped = ClassifyEscapes(w.hits, n, w.queue->queue);
  MoveEscaped(rays, w.queue->queue, n, w.escaped);
  clock.Lap(Stage::kPartition);
  AddEscaped(frame, Points(frame, w), w.escaped, escaped, w.paths);
  clock.Lap(Stage::kEscape);
}

// The light samples of every surface, one after the other: draw, evaluate, trace, add. Directional
// lights come light by light, so that a stream of shadow rays has one direction.
void LightSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock) {
  const ShadePoints points = Points(frame, w);
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const LightPlan plan = frame.strategy->Plan(frame.light_samples());
  for (std::uint32_t index = 0; index < plan.total(); ++index) {
    SampleLights(frame, points, plan, bounce, index, w.uniforms, w.lights);
    CheckLightSamples(w.lights, n);
    clock.Lap(Stage::kLightSample);
    EvaluateLights(frame, w.surfaces, w.ranges, w.lights);
    CountShadowRays(w.stats, w.lights, n);
    clock.Lap(Stage::kEvaluate);
    // The first light sample has one of the bounce's numbers, later ones are numbered behind.
    const std::uint32_t event = SamplePair(bounce, SampleUse::kLight) + kPairBlock * index;
    TraceShadows(frame.tracer, w.surfaces, n, w.lights,
                 RayKeys(frame, w.paths, w.surfaces->path, n, event, w.queue->queue));
    clock.Lap(Stage::kShadow);
    AddUnoccludedRadiance(w.lights, w.surfaces->path, n, w.paths);
    clock.Lap(Stage::kAccumulate);
  }
}

void FinishWave(std::uint32_t n, Worker& w, Film& film, StageClock& clock) {
  film.Add(w.paths, n, w.stats);
  ++w.stats.waves;
  clock.Lap(Stage::kFilm);
}

}  // namespace

void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, w.uniforms, w.lobe, w.paths, *rays);
  clock.Lap(Stage::kGenerate);

  std::uint32_t n = range.count;
  for (std::uint32_t bounce = 0; n > 0; ++bounce) {
    CheckRays(*rays, n);
    CountRays(w.stats, bounce, n, w.paths.rows());
    if (bounce == frame.options.max_depth) {
      MeetSky(frame, bounce, *rays, n, w, clock);
      break;
    }
    MeetSurfaces(frame, bounce, *rays, n, /*only_delta=*/false, w, clock);
    LightSurfaces(frame, bounce, w, clock);
    const bool last = bounce + 1 == frame.options.max_depth;
    n = Scatter(frame, w.paths, w.surfaces, w.ranges, last ? frame.first_bsdf_that_sees_light() : 0,
                bounce, w.uniforms, w.lobe, *next);
    clock.Lap(Stage::kScatter);
    std::swap(rays, next);
  }
  FinishWave(range.count, w, film, clock);
}

void RenderDirectWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, w.uniforms, w.lobe, w.paths, *rays);
  clock.Lap(Stage::kGenerate);

  std::uint32_t n = range.count;
  bool delta_rays = true;
  for (std::uint32_t bounce = 0; n > 0; ++bounce) {
    CheckRays(*rays, n);
    CountRays(w.stats, bounce, n, w.paths.rows());
    if (bounce == frame.options.max_depth || !delta_rays) {
      MeetSky(frame, bounce, *rays, n, w, clock);
      break;
    }
    MeetSurfaces(frame, bounce, *rays, n, /*only_delta=*/true, w, clock);
    LightSurfaces(frame, bounce, w, clock);
    n = Scatter(frame, w.paths, w.surfaces, w.ranges, frame.first_bsdf_that_sees_light(), bounce,
                w.uniforms, w.lobe, *next);
    delta_rays = w.ranges.total() > w.ranges.light_sampled();
    clock.Lap(Stage::kScatter);
    std::swap(rays, next);
  }
  FinishWave(range.count, w, film, clock);
}

}  // namespace skywave
