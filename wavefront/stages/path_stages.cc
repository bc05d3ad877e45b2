#include "wavefront/stages/path_stages.h"

#include <algorithm>
#include <utility>

#include "kernels/accumulate.h"
#include "kernels/partition.h"
#include "kernels/sampler.h"
#include "kernels/surface/surface.h"
#include "wavefront/stages/checks.h"
#include "wavefront/stages/links.h"
#include "wavefront/stages/place.h"
#include "wavefront/stages/projection.h"

namespace skywave {
namespace {

// Returns the kind of the rays that arrive at a bounce.
RayKind KindOf(std::uint32_t bounce) { return bounce == 0 ? RayKind::kCamera : RayKind::kBounce; }

// Checks and counts rays [0, n) before they are traced.
void CountRays(const RayColumns& rays, std::uint32_t n, std::uint32_t bounce, Worker& w) {
  CheckRays(rays, n);
  w.stats.rays[std::uint32_t(KindOf(bounce))] += n;
  BounceOccupancy& occupancy = w.stats.bounces[std::min(bounce, kCountedBounces - 1)];
  occupancy.rows += n;
  occupancy.capacity += w.paths.rows();
}

// Lets rays [0, n) that begin paths at holdouts end there with nothing: they are of no surface, and
// see no light.
void CutHoldouts(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                 std::uint32_t bounce, const HitColumns& hits) {
  const std::uint8_t* const holdouts = frame.geometry->holdouts();
  if (holdouts == nullptr || bounce > 0) return;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (hits.geom[i] == kNoHit) continue;
    if (holdouts[MaterialOf(frame.tracer.triangles[hits.triangle[i]])] == 0) continue;
    hits.geom[i] = kNoHit;
    rays.throughput_r[i] = rays.throughput_g[i] = rays.throughput_b[i] = 0;
  }
}

// Makes the keys of the rays that arrive at a bounce.
RayKeys PathRayKeys(const FrameView& frame, const PathEnd& end, std::uint32_t bounce,
                    const RayColumns& rays, std::uint32_t n, const Worker& w) {
  return MakeRayKeys(frame, w.paths, rays.path, n,
                     end.pairs + SamplePair(bounce, SampleUse::kScatter), w.scratch);
}

}  // namespace

std::uint32_t CountOpen(const LightColumns& lights, std::uint32_t n) {
  std::uint32_t open = 0;
  for (std::uint32_t i = 0; i < n; ++i) open += lights.t_far[i] >= 0;
  return open;
}

ShadePoints Points(const FrameView& frame, const Worker& w) { return PointsIn(w.ranges, frame, w); }

ShadePoints PointsIn(const SurfaceRanges& ranges, const FrameView& frame, const Worker& w) {
  return {.surfaces = w.surfaces,
          .ranges = ranges,
          .materials = frame.geometry->materials(),
          .paths = w.paths};
}

Departure FromOwnSurfaces(const FrameView& frame, const Worker& w) {
  return {.frame = frame, .points = Points(frame, w), .paths = w.paths};
}

void RememberSurfaces(const Worker& w) {
  const std::uint32_t* const path = w.surfaces->path;
  const std::uint32_t dense = w.ranges.light_sampled(), total = w.ranges.total();
  for (std::uint32_t row = 0; row < dense; ++row) w.history->met[path[row]] |= kMetDense;
  for (std::uint32_t row = dense; row < total; ++row) w.history->met[path[row]] |= kMetDelta;
}

void StartGroups(const FrameView& frame, std::uint32_t n, Film& film, Worker& w) {
  if (frame.light_groups == nullptr) return;
  w.of<GroupTables>().film = &film;
  const GroupColumns& given = w.of<GroupTables>().given;
  for (float* column : {given.r, given.g, given.b}) std::fill_n(column, n, 0.0f);
}

namespace {

// Writes the group of the light that rays [0, n) have hit, or the environment's if they hit none.
void GroupsOfHits(const FrameView& frame, const HitColumns& hits, std::uint32_t n,
                  std::uint32_t* group) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t light = hits.geom[i] == kNoHit || !frame.has_emitters()
                                    ? kNoLight
                                    : frame.local_lights.light_of_triangle[hits.triangle[i]];
    group[i] = light == kNoLight ? kEnvironmentGroup : frame.light_groups->of_light[light];
  }
}

// Writes the groups of the light that comes from infinitely far away in directions [0, n).
void GroupsOfDirections(const FrameView& frame, const float* x, const float* y, const float* z,
                        std::uint32_t n, std::uint32_t* group) {
  std::fill_n(group, n, kEnvironmentGroup);
  if (frame.light_groups->sky.division == SkyDivision::kNone) return;
  for (std::uint32_t i = 0; i < n; ++i) {
    group[i] = frame.light_groups->OfDirection(x[i], y[i], z[i]);
  }
}

// Writes the group of the light that light samples of surfaces [0, n) went to.
void GroupsOfLightSamples(const FrameView& frame, const LightReach& reach,
                          const LightColumns& lights, std::uint32_t n, std::uint32_t* group) {
  GroupsOfDirections(frame, lights.dir_x, lights.dir_y, lights.dir_z, n, group);
  ForEachLocalLight(reach, n, [&](std::uint32_t i, std::size_t light) {
    group[i] = frame.light_groups->of_light[light];
  });
}

// Gives what paths have gained in a stage to the groups of their lights, if they are wanted. The
// current rays or surfaces are of paths rows[0, n); `write` writes their groups.
template <class Write>
void KeepGroups(const FrameView& frame, const std::uint32_t* rows, std::uint32_t n, Worker& w,
                const Write& write) {
  if (frame.light_groups == nullptr) return;
  write(w.of<GroupTables>().given->group);
  w.of<GroupTables>().film->AddToGroups(w.paths, rows, n, w.of<GroupTables>().given);
}

// Moves those of rays [0, n) that count with what they see of the environment to w.escaped: those
// that escaped, and with a control variate those from which something is subtracted, whatever they
// hit. Returns their number. Rays from the camera have no control yet.
std::uint32_t MoveSeeing(const FrameView& frame, const RayColumns& rays, const RayQueues& queues,
                         std::uint32_t n, std::uint32_t escaped, std::uint32_t bounce, Worker& w) {
  if (frame.find<ControlView>() != nullptr && bounce > 0) {
    return MoveControlled(rays, queues->queue, n, ControlsOf(frame, w).out, w.escaped);
  }
  MoveEscaped(rays, queues->queue, n, w.escaped);
  return escaped;
}

}  // namespace

void SeeLights(const FrameView& frame, const RayColumns& rays, const RayQueues& queues,
               std::uint32_t n, std::uint32_t escaped, std::uint32_t bounce, const Departure& from,
               Worker& w, StageClock& clock) {
  HideLights(frame, rays, n, bounce, from.points.surfaces, w);
  escaped = MoveSeeing(frame, rays, queues, n, escaped, bounce, w);
  if (bounce == 0 && !frame.shows_background) escaped = 0;
  CountEscaping(n, escaped, w.stats.lanes);
  clock.Lap(Stage::kPartition);
  // This comes before the surfaces that the rays left are overwritten, because strategies may need
  // them.
  AddEscaped(from.frame, from.points, from.met, w.escaped, escaped, from.paths);
  KeepGroups(frame, rays.path, n, w, [&](std::uint32_t* group) {
    GroupsOfDirections(frame, rays.dir_x, rays.dir_y, rays.dir_z, n, group);
  });
  AddEmitted(from.frame, rays, w.hits, n, from.points.surfaces, EmitterHits(w.escaped), from.paths);
  ShowLights(frame, rays, n, w);
  KeepGroups(frame, rays.path, n, w,
             [&](std::uint32_t* group) { GroupsOfHits(frame, w.hits, n, group); });
  clock.Lap(Stage::kEscape);
}

ControlRows ControlsOf(const FrameView& frame, const Worker& w) {
  const auto* const known = frame.find<ControlView>();
  const auto* const tables = w.tables.find<ControlTables>();
  if (known == nullptr || tables == nullptr) return {};
  return {.out = tables->subtracted, .weight = known->weighs() ? tables->weights->weight : nullptr};
}

SortedHits TraceAndSort(const FrameView& frame, const PathEnd& end, const RayColumns& rays,
                        std::uint32_t n, std::uint32_t bounce, bool only_delta, Worker& w,
                        StageClock& clock) {
  CountRays(rays, n, bounce, w);
  {
    const RayKeys keys = PathRayKeys(frame, end, bounce, rays, n, w);
    TraceClosest(frame.tracer, KindOf(bounce), rays, n, w.hits, keys->key);
  }
  clock.Lap(Stage::kIntersect, KindOf(bounce));
  CutHoldouts(frame, rays, n, bounce, w.hits);
  SeeObjects(frame, rays, n, bounce, /*known=*/true, w);
  if (frame.geometry->has_mixtures()) {
    const MixtureUniforms mixture(w.scratch);
    DrawUniforms(w.paths, rays.path, n, end.pairs + MixturePair(bounce), {}, mixture);
    ChooseMaterials(frame.geometry->triangles(), frame.geometry->textures(), mixture->u, n, w.hits);
  }
  CountTracing(n, w.stats.lanes);
  SortedHits sorted = {.queues = RayQueues(w.scratch), .ranges = {}, .escaped = 0};
  sorted.escaped =
      SortHits(*frame.geometry, rays, w.hits, n, only_delta, sorted.queues, sorted.ranges);
  return sorted;
}

void PrepareHits(const FrameView& frame, const PathEnd& end, const RayColumns& rays,
                 std::uint32_t n, const SortedHits& sorted, Worker& w, StageClock& clock) {
  w.ranges = sorted.ranges;
  MoveSurfaces(*frame.geometry, rays, w.hits, sorted.queues, n, w.ranges, w.surfaces);
  CountHits(n, w.ranges, w.stats.lanes);
  clock.Lap(Stage::kPartition);
  PrepareSurfaces(frame.geometry->triangle_tables(), frame.geometry->materials().records,
                  w.ranges.total(), w.surfaces);
  TextureSurfaces(frame, end, w.ranges, w.surfaces);
  if (const auto* const known = frame.find<ControlView>(); known != nullptr && known->weighs()) {
    FindControlWeights(known->weights, w.ranges.total(), w.surfaces, w.of<ControlTables>().weights);
  }
  CheckSurfaces(w.surfaces, w.ranges.total());
  clock.Lap(Stage::kSurface);
}

void PrepareHits(const FrameView& frame, const PathEnd& end, const RayColumns& rays,
                 std::uint32_t n, SortedHits&& sorted, Worker& w, StageClock& clock) {
  const SortedHits ending = std::move(sorted);
  PrepareHits(frame, end, rays, n, ending, w, clock);
}

void IntersectSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                       std::uint32_t bounce, bool only_delta, Worker& w, StageClock& clock) {
  IntersectSurfaces(frame, rays, n, bounce, only_delta, FromOwnSurfaces(frame, w), w, clock);
}

void IntersectSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                       std::uint32_t bounce, bool only_delta, const Departure& from, Worker& w,
                       StageClock& clock) {
  SortedHits sorted = TraceAndSort(frame, kCameraEnd, rays, n, bounce, only_delta, w, clock);
  SeeLights(frame, rays, sorted.queues, n, sorted.escaped, bounce, from, w, clock);
  PrepareHits(frame, kCameraEnd, rays, n, std::move(sorted), w, clock);
  ColorCatchers(frame, w);
}

void IntersectLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                     std::uint32_t bounce, Worker& w, StageClock& clock) {
  IntersectLights(frame, rays, n, bounce, FromOwnSurfaces(frame, w), w, clock);
}

void IntersectLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                     std::uint32_t bounce, const Departure& from, Worker& w, StageClock& clock) {
  CountRays(rays, n, bounce, w);
  {
    const RayKeys keys = PathRayKeys(frame, kCameraEnd, bounce, rays, n, w);
    if (frame.has_emitters()) {
      TraceClosest(frame.tracer, KindOf(bounce), rays, n, w.hits, keys->key);
      CutHoldouts(frame, rays, n, bounce, w.hits);
    } else {
      TraceEscapes(frame.tracer, KindOf(bounce), rays, n, w.hits, keys->key);
    }
  }
  clock.Lap(Stage::kIntersect, KindOf(bounce));
  SeeObjects(frame, rays, n, bounce, /*known=*/frame.has_emitters(), w);
  const RayQueues queues(w.scratch);
  const std::uint32_t escaped = ClassifyEscapes(w.hits, n, queues->queue);
  CountTracing(n, w.stats.lanes);
  SeeLights(frame, rays, queues, n, escaped, bounce, from, w, clock);
}

void TraceLights(const FrameView& frame, ShadowTarget target, const RayKeys& keys, Worker& w,
                 StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  const std::uint32_t open = CountOpen(w.lights, n);
  w.stats.rays[std::uint32_t(RayKind::kShadow)] += open;
  CheckShadowRays(w.lights, n);
  clock.Lap(Stage::kEvaluate);
  const auto trace = target == ShadowTarget::kCamera ? TraceToCamera : TraceShadows;
  BeforeShadows(frame, w);
  TraceByLinks(frame, w,
               [&](const Tracer& tracer) { trace(tracer, w.surfaces, n, w.lights, keys->key); });
  AfterShadows(frame, w);
  clock.Lap(Stage::kShadow, RayKind::kShadow);
  CountLighting(w.ranges, open, CountOpen(w.lights, n), w.stats.lanes);
}

void LightSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock,
                   std::uint32_t pairs) {
  const ShadePoints points = Points(frame, w);
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const LightShares shares = frame.light_shares();
  for (std::uint32_t index = 0; index < shares.total(); ++index) {
    const LightUniforms uniforms(w.scratch);
    const LightPlaces places(w.hits);
    const LightReach reach =
        SampleLights(frame, points, shares, pairs + SamplePair(bounce, SampleUse::kLight), index,
                     uniforms, w.scratch, w.lights, places);
    CheckLightSamples(w.lights, n);
    LinkSamples(frame, reach, w);
    clock.Lap(Stage::kLightSample);
    EvaluateLights(frame, w.surfaces, w.ranges, reach, index, w.lights, ControlsOf(frame, w));
    SeeObjectLamps(frame, reach, w);
    // The first light sample has one of the bounce's numbers; later ones are numbered after those.
    const std::uint32_t event = pairs + SamplePair(bounce, SampleUse::kLight) + kPairBlock * index;
    const RayKeys keys = MakeRayKeys(frame, w.paths, w.surfaces->path, n, event, w.scratch);
    if (reach.limited() && frame.local_lights.has_alpha) {
      CloseTransparentSamples(frame, places, keys, n, w.lights->t_far);
    }
    TraceLights(frame, ShadowTarget::kLight, keys, w, clock);
    if (frame.find<ControlView>() != nullptr) {
      SubtractControl(ControlsOf(frame, w).out, w.surfaces->path, n, w.paths);
      KeepGroups(frame, w.surfaces->path, n, w,
                 [&](std::uint32_t* group) { std::fill_n(group, n, kEnvironmentGroup); });
    }
    AddUnoccludedRadiance(w.lights, w.surfaces->path, n, w.paths);
    KeepGroups(frame, w.surfaces->path, n, w, [&](std::uint32_t* group) {
      GroupsOfLightSamples(frame, reach, w.lights, n, group);
    });
    clock.Lap(Stage::kAccumulate);
  }
}

std::uint32_t ScatterSurfaces(const FrameView& frame, const PathEnd& end, std::uint32_t first_kind,
                              std::uint32_t bounce, const RayColumns& rays, Worker& w,
                              StageClock& clock) {
  const std::uint32_t n = Scatter(frame, Points(frame, w), {end, bounce, first_kind}, w.scratch,
                                  rays, ControlsOf(frame, w));
  CountScattering(w.ranges, first_kind, w.stats.lanes);
  clock.Lap(Stage::kScatter);
  return n;
}

void KeepAovs(const FrameView& frame, std::uint32_t bounce, std::uint32_t paths, const Worker& w,
              Film& film, StageClock& clock) {
  if (!film.has_aovs()) return;
  if (bounce == 0) {
    // They are drawn again, because their columns have been used for others since generation.
    const FilmUniforms uniforms(w.scratch);
    DrawUniforms(w.paths, nullptr, paths, kFilmPair, {}, uniforms);
    film.AddFirstHits({.first = {.geometry = *frame.geometry,
                                 .camera = frame.camera,
                                 .surfaces = w.surfaces,
                                 .count = w.ranges.total(),
                                 .tracer = &frame.tracer,
                                 .motion = frame.find<FrameMotion>()},
                       .paths = w.paths,
                       .hits = w.hits,
                       .film = uniforms,
                       .filter = frame.filter,
                       .rays = paths});
  }
  // The rays that left the first surfaces have met the environment; the second surfaces are not lit
  // yet.
  if (bounce == kFirstIndirectBounce) film.AddDirect(w.paths, paths);
  clock.Lap(Stage::kFilm);
}

void KeepDirectOfEnded(std::uint32_t n, std::uint32_t bounce, const Worker& w, Film& film) {
  if (bounce <= kFirstIndirectBounce) film.AddDirect(w.paths, n);
}

void FinishPaths(const FrameView& frame, std::uint32_t n, Worker& w, Film& film,
                 StageClock& clock) {
  WeighByFilter(frame, n, w);
  film.Add(w.paths, n, w.stats);
  KeepLightParts(frame, n, w, film);
  // Every path of the wave passes these two kernels.
  for (const Kernel kernel : {Kernel::kGenerate, Kernel::kFilm}) {
    w.stats.lanes[std::uint32_t(kernel)].Add(n, n);
  }
  ++w.stats.waves;
  clock.Lap(Stage::kFilm);
}

void FinishWave(const FrameView& frame, std::uint32_t n, std::uint32_t bounce, Worker& w,
                Film& film, StageClock& clock) {
  KeepDirectOfEnded(n, bounce, w, film);
  FinishPaths(frame, n, w, film, clock);
}

}  // namespace skywave
