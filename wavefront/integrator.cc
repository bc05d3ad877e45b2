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

// Light samples of this bounce are the first that meet two surfaces on their way to the camera.
constexpr std::uint32_t kFirstIndirectBounce = 1;

RayKind KindOf(std::uint32_t bounce) { return bounce == 0 ? RayKind::kCamera : RayKind::kBounce; }

void CountRays(RenderStats& stats, std::uint32_t bounce, std::uint32_t n, std::uint32_t wave) {
  stats.rays[std::uint32_t(KindOf(bounce))] += n;
  BounceOccupancy& occupancy = stats.bounces[std::min(bounce, kCountedBounces - 1)];
  occupancy.rows += n;
  occupancy.capacity += wave;
}

// Shadow rays that are there to be traced or, once traced, that met nothing.
std::uint32_t CountOpen(const LightColumns& lights, std::uint32_t n) {
  std::uint32_t open = 0;
  for (std::uint32_t i = 0; i < n; ++i) open += lights.t_far[i] >= 0;
  return open;
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

// What paths have gained in a stage, to the groups of their lights, where somebody asks for them.
// The rays or surfaces at hand are of paths rows[0, n); `write` writes their groups.
template <class Write>
void KeepGroups(const FrameView& frame, const std::uint32_t* rows, std::uint32_t n, Worker& w,
                Film& film, const Write& write) {
  if (frame.light_groups == nullptr) return;
  write(w.groups->group);
  film.AddToGroups(w.paths, rows, n, w.groups);
}

void StartGroups(const FrameView& frame, std::uint32_t n, Worker& w) {
  if (frame.light_groups == nullptr) return;
  if (w.groups.rows() == 0) w.groups = soa::Table<GroupColumns>(w.paths.rows());
  for (float* column : {w.groups->r, w.groups->g, w.groups->b}) std::fill_n(column, n, 0.0f);
}

// Adds what rays [0, n) that have been traced see of the sky, `escaped` of them, and of lamps.
void SeeLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
               std::uint32_t escaped, Worker& w, Film& film) {
  AddEscaped(frame, Points(frame, w), w.escaped, escaped, w.paths);
  KeepGroups(frame, rays.path, n, w, film,
             [&](std::uint32_t* group) { std::fill_n(group, n, kEnvironmentGroup); });
  AddEmitted(frame, rays, w.hits, n, w.escaped, w.paths);
  KeepGroups(frame, rays.path, n, w, film,
             [&](std::uint32_t* group) { GroupsOfHits(frame, w.hits, n, group); });
}

// Traces rays [0, n), adds what the escaped ones see, and makes surfaces to shade of the hits.
void MeetSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                  std::uint32_t bounce, bool only_delta, Worker& w, Film& film, StageClock& clock) {
  const MaterialView materials = frame.geometry->materials();
  SurfaceRanges ranges;
  TraceClosest(frame.tracer, KindOf(bounce), rays, n, w.hits,
               PathRayKeys(frame, bounce, rays, n, w));
  clock.Lap(Stage::kIntersect, KindOf(bounce));
  if (frame.geometry->has_mixtures()) {
    DrawUniforms(w.paths, rays.path, n, MixturePair(bounce), {}, w.uniforms);
    ChooseMaterials(frame.geometry->triangles(), w.uniforms->u, n, w.hits);
  }
  const std::uint32_t escaped =
      SortHits(*frame.geometry, rays, w.hits, n, only_delta, w.queue->queue, ranges);
  MoveEscaped(rays, w.queue->queue, n, w.escaped);
  clock.Lap(Stage::kPartition);
  // Before the surfaces that the rays left are overwritten: strategies may ask for them.
  SeeLights(frame, rays, n, escaped, w, film);
  clock.Lap(Stage::kEscape);
  w.ranges = ranges;
  MoveSurfaces(rays, w.hits, w.queue->queue, n, ranges, w.surfaces);
  CountMeeting(n, escaped, ranges, w.stats.lanes);
  clock.Lap(Stage::kPartition);
  PrepareSurfaces(frame.geometry->triangles(), materials.records, ranges.total(), w.surfaces);
  TextureSurfaces(frame, ranges, w.surfaces);
  CheckSurfaces(w.surfaces, ranges.total());
  clock.Lap(Stage::kSurface);
}

// The end of a path: only what shines by itself can still be seen.
void MeetLight(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
               std::uint32_t bounce, Worker& w, Film& film, StageClock& clock) {
  const std::uint32_t* const keys = PathRayKeys(frame, bounce, rays, n, w);
  if (frame.has_emitters()) {
    TraceClosest(frame.tracer, KindOf(bounce), rays, n, w.hits, keys);
  } else {
    TraceEscapes(frame.tracer, KindOf(bounce), rays, n, w.hits, keys);
  }
  clock.Lap(Stage::kIntersect, KindOf(bounce));
  const std::uint32_t escaped = ClassifyEscapes(w.hits, n, w.queue->queue);
  MoveEscaped(rays, w.queue->queue, n, w.escaped);
  CountMeeting(n, escaped, {}, w.stats.lanes);
  clock.Lap(Stage::kPartition);
  SeeLights(frame, rays, n, escaped, w, film);
  clock.Lap(Stage::kEscape);
}

// The light samples of every surface, one after the other: draw, evaluate, trace, add. Directional
// lights come light by light, so that a stream of shadow rays has one direction.
void LightSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, Film& film,
                   StageClock& clock) {
  const ShadePoints points = Points(frame, w);
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const LightShares shares = frame.light_shares();
  for (std::uint32_t index = 0; index < shares.plan.total(); ++index) {
    const float* reach =
        SampleLights(frame, points, shares, bounce, index, w.uniforms, w.lobe, w.lights, w.hits);
    CheckLightSamples(w.lights, n);
    clock.Lap(Stage::kLightSample);
    EvaluateLights(frame, w.surfaces, w.ranges, reach, w.lights);
    // The first light sample has one of the bounce's numbers, later ones are numbered behind.
    const std::uint32_t event = SamplePair(bounce, SampleUse::kLight) + kPairBlock * index;
    const std::uint32_t* const keys =
        RayKeys(frame, w.paths, w.surfaces->path, n, event, w.queue->queue);
    if (reach != nullptr && frame.local_lights.holes) CloseHoles(frame, w.hits, keys, n, w.lights);
    const std::uint32_t open = CountOpen(w.lights, n);
    w.stats.rays[std::uint32_t(RayKind::kShadow)] += open;
    clock.Lap(Stage::kEvaluate);
    TraceShadows(frame.tracer, w.surfaces, n, w.lights, keys);
    clock.Lap(Stage::kShadow, RayKind::kShadow);
    CountLighting(w.ranges, open, CountOpen(w.lights, n), w.stats.lanes);
    AddUnoccludedRadiance(w.lights, w.surfaces->path, n, w.paths);
    KeepGroups(frame, w.surfaces->path, n, w, film, [&](std::uint32_t* group) {
      GroupsOfLightSamples(frame, shares, index, w.uniforms->u, n, group);
    });
    clock.Lap(Stage::kAccumulate);
  }
}

// What the film keeps of a bounce beside radiance, where it is asked to.
void KeepAovs(const FrameView& frame, std::uint32_t bounce, std::uint32_t paths, const Worker& w,
              Film& film, StageClock& clock) {
  if (!film.has_aovs()) return;
  if (bounce == 0) {
    film.AddFirstHits({.first = {.frame = frame, .surfaces = w.surfaces, .count = w.ranges.total()},
                       .paths = w.paths,
                       .hits = w.hits,
                       .film = w.uniforms,
                       .rays = paths});
  }
  // The rays that left the first surfaces have met the sky; the second ones are not lit yet.
  if (bounce == kFirstIndirectBounce) film.AddDirect(w.paths, paths);
  clock.Lap(Stage::kFilm);
}

// `bounce`: at which the last path ended.
void FinishWave(std::uint32_t n, std::uint32_t bounce, Worker& w, Film& film, StageClock& clock) {
  film.Add(w.paths, n, w.stats);
  if (bounce <= kFirstIndirectBounce) film.AddDirect(w.paths, n);
  // Of the two kernels that every path of the wave passes.
  for (const Kernel kernel : {Kernel::kGenerate, Kernel::kFilm}) {
    w.stats.lanes[std::uint32_t(kernel)].Add(n, n);
  }
  ++w.stats.waves;
  clock.Lap(Stage::kFilm);
}

}  // namespace

void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, w.uniforms, w.lobe, w.paths, *rays);
  StartGroups(frame, range.count, w);
  clock.Lap(Stage::kGenerate);

  std::uint32_t n = range.count, bounce = 0;
  for (; n > 0; ++bounce) {
    CheckRays(*rays, n);
    CountRays(w.stats, bounce, n, w.paths.rows());
    if (bounce == frame.options.max_depth) {
      MeetLight(frame, *rays, n, bounce, w, film, clock);
      break;
    }
    MeetSurfaces(frame, *rays, n, bounce, /*only_delta=*/false, w, film, clock);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    LightSurfaces(frame, bounce, w, film, clock);
    const bool last = bounce + 1 == frame.options.max_depth;
    const std::uint32_t first_kind = last ? frame.first_bsdf_that_sees_light() : 0;
    n = Scatter(frame, w.paths, w.surfaces, w.ranges, first_kind, bounce, w.uniforms, w.lobe,
                *next);
    CountScattering(w.ranges, first_kind, w.stats.lanes);
    clock.Lap(Stage::kScatter);
    std::swap(rays, next);
  }
  FinishWave(range.count, bounce, w, film, clock);
}

void RenderDirectWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, w.uniforms, w.lobe, w.paths, *rays);
  StartGroups(frame, range.count, w);
  clock.Lap(Stage::kGenerate);

  std::uint32_t n = range.count, bounce = 0;
  bool delta_rays = true;
  for (; n > 0; ++bounce) {
    CheckRays(*rays, n);
    CountRays(w.stats, bounce, n, w.paths.rows());
    if (bounce == frame.options.max_depth || !delta_rays) {
      MeetLight(frame, *rays, n, bounce, w, film, clock);
      break;
    }
    MeetSurfaces(frame, *rays, n, bounce, /*only_delta=*/true, w, film, clock);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    LightSurfaces(frame, bounce, w, film, clock);
    n = Scatter(frame, w.paths, w.surfaces, w.ranges, frame.first_bsdf_that_sees_light(), bounce,
                w.uniforms, w.lobe, *next);
    CountScattering(w.ranges, frame.first_bsdf_that_sees_light(), w.stats.lanes);
    delta_rays = w.ranges.total() > w.ranges.light_sampled();
    clock.Lap(Stage::kScatter);
    std::swap(rays, next);
  }
  FinishWave(range.count, bounce, w, film, clock);
}

}  // namespace skywave
