#include "wavefront/stages/bidirectional.h"

#include <algorithm>
#include <utility>

#include "kernels/accumulate.h"
#include "kernels/light_paths/arrival.h"
#include "kernels/light_paths/flux.h"
#include "kernels/sampler.h"
#include "wavefront/stages/checks.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Writes the directions of rays [0, n) to the rows of the surfaces that they leave.
void SpreadDirections(const RayColumns& rays, std::uint32_t n,
                      const ScatteredDirections& directions) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t row = rays.from[i];
    directions->dir_x[row] = rays.dir_x[i];
    directions->dir_y[row] = rays.dir_y[i];
    directions->dir_z[row] = rays.dir_z[i];
  }
}

// Traces the shadow rays of w.lights, one for each of the eye's surfaces that take light samples,
// and adds what arrives.
void TraceAndAdd(const FrameView& frame, const RayKeys& keys, Worker& w, StageClock& clock) {
  TraceLights(frame, ShadowTarget::kLight, keys, w, clock);
  AddUnoccludedRadiance(w.lights, w.surfaces->path, w.ranges.light_sampled(), w.paths);
  clock.Lap(Stage::kAccumulate);
}

}  // namespace

MisTechniques TechniquesOf(const FrameView& frame) {
  const auto* const merging = frame.find<Merging>();
  return {.mis = frame.mis(), .eta_vcm = merging != nullptr ? merging->eta_vcm : 0};
}

void EvaluateBackward(const MaterialView& materials, const SurfaceColumns& surfaces,
                      const SurfaceRanges& ranges, const LightColumns& lights,
                      const TurnedColumns& turned, const BsdfValueColumns& out) {
  ForEachBsdf(ranges, kDenseBsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& at) {
    const std::uint32_t n = at.n;
    SurfaceColumns rows = Slice(surfaces, at.begin);
    LightColumns to = Slice(lights, at.begin);
    const TurnedColumns seen = Slice(turned, at.begin);
    FaceNormals(rows, to, n, {seen.ns_x, seen.ns_y, seen.ns_z});
    rows.ns_x = seen.ns_x, rows.ns_y = seen.ns_y, rows.ns_z = seen.ns_z;
    if (bsdf.transmits) {
      TurnSurfaces(rows, to, n, seen);
      rows.ng_x = seen.ng_x, rows.ng_y = seen.ng_y, rows.ng_z = seen.ng_z;
      rows.material = seen.material;
    }
    std::swap(rows.wo_x, to.dir_x), std::swap(rows.wo_y, to.dir_y), std::swap(rows.wo_z, to.dir_z);
    bsdf.evaluate(rows, materials, to, n, Slice(out, at.begin));
    ClearUnseen(rows, n, Slice(out, at.begin));
  });
}

void EvaluateBothDirections(const MaterialView& materials, const SurfaceColumns& surfaces,
                            const SurfaceRanges& ranges, const LightColumns& lights,
                            const TurnedColumns& turned, const BothDirections& out) {
  ForEachBsdf(ranges, kDenseBsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& at) {
    const SurfaceColumns rows = Slice(surfaces, at.begin);
    const LightColumns to = Slice(lights, at.begin);
    bsdf.evaluate(rows, materials, to, at.n, Slice(out.forward.columns(), at.begin));
    if (bsdf.transmits) MoveToSide(to, at.n, rows);
  });
  EvaluateBackward(materials, surfaces, ranges, lights, turned, out.backward);
}

void LeaveCamera(const FrameView& frame, const LensUniforms& lens, std::uint32_t n, Worker& w) {
  const BidirectionalTables& b = w.of<BidirectionalTables>();
  const RayColumns& rays = b.eye_rays;
  // The camera is asked for points that its rays pass, a unit away.
  const CameraRayPoints points(w.surfaces);
  for (std::uint32_t i = 0; i < n; ++i) {
    points->x[i] = rays.org_x[i] + rays.dir_x[i];
    points->y[i] = rays.org_y[i] + rays.dir_y[i];
    points->z[i] = rays.org_z[i] + rays.dir_z[i];
  }
  ConnectCamera(frame.camera, points.as_surfaces(), lens, n, w.lights,
                w.of<LightPathTables>().cameras);
  LeaveEye(w.of<LightPathTables>().cameras->importance, float(frame.light_paths()),
           frame.camera.kind == CameraKind::kOrthographic, n, b.eye);
}

std::uint32_t ScatterSubpaths(const FrameView& frame, const PathEnd& end, const SubpathColumns& at,
                              std::uint32_t first_kind, std::uint32_t bounce,
                              const RayColumns& rays, const SubpathColumns& flying, Worker& w,
                              StageClock& clock) {
  const BidirectionalTables& b = w.of<BidirectionalTables>();
  const std::uint32_t n =
      Scatter(frame, Points(frame, w), {end, bounce, first_kind}, w.scratch, rays);
  CountScattering(w.ranges, first_kind, w.stats.lanes);
  const ScatteredDirections directions(w.lights);
  SpreadDirections(rays, n, directions);
  EvaluateBackward(frame.geometry->materials(), w.surfaces, w.ranges, directions, b.turned,
                   b.seen.backward);
  LeaveSurfaces(w.surfaces, at, b.seen.backward->pdf, TechniquesOf(frame), rays, n, flying);
  clock.Lap(Stage::kScatter);
  return n;
}

void AddHitLight(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                 std::uint32_t escaped, std::uint32_t bounce, Worker& w, StageClock& clock) {
  const BidirectionalTables& b = w.of<BidirectionalTables>();
  const LightShares shares = frame.light_shares();
  const auto add = [&](const EscapeColumns& rows, std::uint32_t count) {
    WeighHitLight(b.eye, b.arrival->pdf, count, frame.mis(), rows);
    AddEscapedRadiance(rows, count, frame.mis(), w.paths);
  };
  // No other technique finds what the camera sees by itself.
  const bool alone = bounce == 0;
  if (escaped > 0 && frame.has_environment()) {
    if (!alone) MarkPartners(b.eye, escaped, w.escaped);
    const float samples = shares.strategy_samples(frame.light_samples());
    frame.strategy->EvaluateEscaped(Points(frame, w), escaped, samples, w.escaped);
    const EscapeColumns& seen = w.escaped;
    // Camera rays have left no surface, and need none.
    if (!alone) {
      EnvironmentArrivals(frame.sphere, GuideOf(frame),
                          {seen.dir_x, seen.dir_y, seen.dir_z, w.surfaces, seen.from}, escaped,
                          b.arrival->pdf);
    }
    add(w.escaped, escaped);
  }
  if (frame.has_emitters()) {
    const EmitterHits emitter_hits(w.escaped);
    const std::uint32_t met =
        IntersectEmitters(frame.local_lights, shares.local, rays, w.hits, n,
                          float(shares.plan.drawn), w.surfaces, emitter_hits, b.arrival->pdf);
    if (!alone) MarkPartners(b.eye, met, emitter_hits);
    add(emitter_hits, met);
  }
  clock.Lap(Stage::kEscape);
}

void ConnectLights(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const BidirectionalTables& b = w.of<BidirectionalTables>();
  const LightShares shares = frame.light_shares();
  const LightUniforms uniforms(w.scratch);
  const LightPlaces places(w.hits);
  const LightReach reach =
      SampleLights(frame, Points(frame, w), shares, SamplePair(bounce, SampleUse::kLight),
                   /*index=*/0, uniforms, w.scratch, w.lights, places);
  CheckLightSamples(w.lights, n);
  const LightColumns& lights = w.lights;
  EnvironmentArrivals(frame.sphere, GuideOf(frame),
                      {lights.dir_x, lights.dir_y, lights.dir_z, w.surfaces, nullptr, lights.pdf},
                      n, b.arrival->pdf);
  if (reach.limited()) {
    SampleArrivals(frame.local_lights, shares.local, w.surfaces, uniforms->u, w.lights, n,
                   b.arrival->pdf);
  }
  clock.Lap(Stage::kLightSample);
  EvaluateBothDirections(frame.geometry->materials(), w.surfaces, w.ranges, w.lights, b.turned,
                         b.seen);
  WeighLightSamples(w.surfaces, b.at, b.seen.forward, b.seen.backward, b.arrival->pdf, n,
                    TechniquesOf(frame), w.lights);
  if (reach.limited()) LimitShadows(reach->distance, n, w.lights);
  const RayKeys keys = MakeRayKeys(frame, w.paths, w.surfaces->path, n,
                                   SamplePair(bounce, SampleUse::kLight), w.scratch);
  if (reach.limited() && frame.local_lights.has_alpha) {
    CloseTransparentSamples(frame, places, keys, n, w.lights->t_far);
  }
  TraceAndAdd(frame, keys, w, clock);
}

void ConnectVertices(const FrameView& frame, std::uint32_t bounce, std::uint32_t light_bounce,
                     Worker& w, StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  const BidirectionalTables& b = w.of<BidirectionalTables>();
  const LightVertices& vertices = b.vertices[light_bounce];
  if (n == 0 || vertices.ranges.light_sampled() == 0) return;
  const MaterialView materials = frame.geometry->materials();
  AimAtVertices(w.surfaces, n, vertices.view(), b.partner->index, w.lights, b.to_eye);
  EvaluateBothDirections(materials, w.surfaces, w.ranges, w.lights, b.turned, b.seen);
  EvaluateBothDirections(materials, vertices.surfaces, vertices.ranges, b.to_eye, b.turned,
                         b.seen_by_light);
  const ConnectionEnds ends = {b.seen.forward, b.seen.backward, b.seen_by_light.forward,
                               b.seen_by_light.backward};
  JoinVertices(w.surfaces, b.at, n, TechniquesOf(frame), vertices.view(), b.partner->index, ends,
               w.lights);
  // These events come after that of the light sample.
  const std::uint32_t event =
      SamplePair(bounce, SampleUse::kLight) + kPairBlock * (light_bounce + 1);
  TraceAndAdd(frame, MakeRayKeys(frame, w.paths, w.surfaces->path, n, event, w.scratch), w, clock);
}

void WeighCameraConnections(const FrameView& frame, const SubpathColumns& at, Worker& w,
                            StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  const BidirectionalTables& b = w.of<BidirectionalTables>();
  EvaluateBackward(frame.geometry->materials(), w.surfaces, w.ranges, w.lights, b.turned,
                   b.seen.backward);
  WeighSplats(w.surfaces, at, b.seen.backward->pdf, w.of<LightPathTables>().cameras->importance,
              float(frame.light_paths()), n, TechniquesOf(frame), w.lights);
  clock.Lap(Stage::kEvaluate);
}

void KeepVertices(Worker& w, LightVertices& vertices) {
  std::fill_n(vertices.row_of_path->index, w.paths.rows(), kNoRow);
  for (std::uint32_t i = 0; i < w.ranges.light_sampled(); ++i) {
    vertices.row_of_path->index[w.surfaces->path[i]] = i;
  }
  vertices.ranges = w.ranges;
  std::swap(w.surfaces, vertices.surfaces);
}

}  // namespace skywave
