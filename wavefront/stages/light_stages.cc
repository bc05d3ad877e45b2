#include "wavefront/stages/light_stages.h"

#include <algorithm>

#include "kernels/light_paths/bidirectional.h"
#include "kernels/light_paths/flux.h"
#include "kernels/lights/directional.h"
#include "kernels/sampler.h"
#include "wavefront/stages/checks.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

constexpr std::uint32_t LightPair(std::uint32_t bounce, SampleUse use) {
  return kLightEnd.pairs + SamplePair(bounce, use);
}

// Evaluates what surfaces send towards the camera, in the directions in w.lights:
// w.of<LightPathTables>().values.
void EvaluateConnections(const FrameView& frame, Worker& w) {
  MaterialView materials = frame.geometry->materials();
  materials.flux = true;
  ForEachBsdf(w.ranges, kDenseBsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& rows) {
    const std::uint32_t n = rows.n;
    const SurfaceColumns surfaces = Slice(w.surfaces.columns(), rows.begin);
    const LightColumns lights = Slice(w.lights.columns(), rows.begin);
    const NormalColumns normals = Slice(w.of<LightPathTables>().normals.columns(), rows.begin);
    SurfaceColumns seen = surfaces;
    seen.ns_x = normals.x, seen.ns_y = normals.y, seen.ns_z = normals.z;
    FaceNormals(surfaces, lights, n, normals);
    const BsdfValueColumns values = Slice(w.of<LightPathTables>().values.columns(), rows.begin);
    bsdf.evaluate(seen, materials, lights, n, values);
    MakeFlux(bsdf, seen, materials, lights, n, values);
    ClearUnseen(seen, n, values);
    if (bsdf.transmits) MoveToSide(lights, n, surfaces);
  });
}

// Closes the connections of surfaces [0, n) whose side towards the camera it does not see.
void CloseHiddenSides(const TriangleRecord* triangles, const SurfaceColumns& surfaces,
                      std::uint32_t n, const LightColumns& lights) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const float towards = surfaces.ng_x[i] * lights.dir_x[i] + surfaces.ng_y[i] * lights.dir_y[i] +
                          surfaces.ng_z[i] * lights.dir_z[i];
    const bool back = (surfaces.material[i] & kBackFace) != 0;
    if (IsHiddenSide(triangles[surfaces.triangle[i]].tag, (towards > 0) != back)) {
      lights.t_far[i] = -1;
    }
  }
}

// Guides the rays that come from infinitely far away. Where their directions were not drawn by the
// strategy, it is asked how it would have drawn them.
void GuideDistantRays(const FrameView& frame, const LightShares& shares, const AimUniforms& aim,
                      std::uint32_t n, const RayColumns& rays, const Worker& w) {
  const EmissionColumns& emission = w.of<LightPathTables>().emission;
  if (!frame.find<EmissionGuide>()->directions) {
    GuideStarts(frame.sphere, GuideOf(frame), aim, nullptr, n, rays, emission);
    return;
  }
  const EnvironmentDensities densities(w.escaped);
  EscapeColumns seen = densities;
  seen.dir_x = w.lights->dir_x, seen.dir_y = w.lights->dir_y, seen.dir_z = w.lights->dir_z;
  std::fill_n(seen.pdf, n, 1.0f);
  frame.strategy->EvaluateEscaped(Points(frame, w), n, shares.of_strategy, seen);
  GuideStarts(frame.sphere, GuideOf(frame), aim, seen.light_pdf, n, rays, emission);
}

}  // namespace

void StartLightPaths(const RenderOptions& options, std::uint64_t first, std::uint32_t n,
                     const PathColumns& paths) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint64_t number = first + i;
    // A sequence has 2^32 points. No pixel of a film has the place that seeds it.
    paths.seed[i] = PixelSeed(~0u, std::uint32_t(number >> 32), options.seed);
    paths.sample[i] = std::uint32_t(number);
    paths.pixel[i] = 0;
  }
  std::fill_n(paths.r, n, 0.0f);
  std::fill_n(paths.g, n, 0.0f);
  std::fill_n(paths.b, n, 0.0f);
}

void EmitRays(const FrameView& frame, std::uint32_t n, const RayColumns& rays, Worker& w,
              StageClock& clock) {
  const LightShares shares = frame.light_shares();
  const auto* const guide = frame.find<EmissionGuide>();
  const std::uint32_t pair = LightPair(0, SampleUse::kLight);
  const LightUniforms uniforms(w.scratch);
  DrawUniforms(w.paths, nullptr, n, pair, {}, uniforms);
  if (shares.local.share < 1) {
    const bool redrawn = guide != nullptr && guide->directions;
    const EnvStrategy& strategy = redrawn ? *guide->directions : *frame.strategy;
    SampleStrategy(strategy, Points(frame, w), uniforms, shares.local.share, n,
                   {.pair = pair, .share = shares.of_strategy}, w.scratch, w.lights);
    CheckLightSamples(w.lights, n);
  }
  const AimUniforms aim(w.scratch);
  DrawUniforms(w.paths, nullptr, n, LightPair(0, SampleUse::kScatter), {}, aim);
  const EmissionColumns& emission = w.of<LightPathTables>().emission;
  if (shares.local.share < 1) {
    EmitFromEnvironment(frame.sphere, w.lights, aim, n, rays, emission);
  }
  if (shares.local.share > 0) {
    const LightPlaces places(w.hits);
    EmitFromLocalLights(frame.local_lights, shares.local, frame.sphere, uniforms, aim, n, rays,
                        emission, places);
    if (frame.local_lights.has_alpha) {
      const RayKeys keys =
          MakeRayKeys(frame, w.paths, rays.path, n, LightPair(0, SampleUse::kLobe), w.scratch);
      CloseTransparentSamples(frame, places, keys, n, rays.t_far);
    }
  }
  if (guide != nullptr) GuideDistantRays(frame, shares, aim, n, rays, w);
  clock.Lap(Stage::kGenerate);
}

void IntersectLightPathSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                                std::uint32_t bounce, Worker& w, StageClock& clock) {
  PrepareHits(frame, kLightEnd, rays, n,
              TraceAndSort(frame, kLightEnd, rays, n, bounce, /*only_delta=*/false, w, clock), w,
              clock);
}

FrameView LightPathView(const FrameView& frame) {
  FrameView view = frame;
  view.strategy = frame.emitter;
  view.options.light_samples = 1;
  return view;
}

void ConnectSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const CameraColumns& cameras = w.of<LightPathTables>().cameras;
  const std::uint32_t pair = LightPair(bounce, SampleUse::kLight);
  const LensUniforms lens(w.scratch);
  if (frame.camera.has_lens()) {
    DrawUniforms(w.paths, w.surfaces->path, n, pair + kPairBlock, {}, lens);
  }
  ConnectCamera(frame.camera, w.surfaces, lens, n, w.lights, cameras);
  const PixelUniforms pixel(w.scratch);
  DrawUniforms(w.paths, w.surfaces->path, n, pair, {}, pixel);
  ChoosePixels(frame.camera, frame.filter, pixel, n, w.lights, cameras);
  EvaluateConnections(frame, w);
  WeighConnections(w.surfaces, w.of<LightPathTables>().values, cameras, n, w.lights);
  if (frame.tracer.one_sided) {
    CloseHiddenSides(frame.tracer.triangles, w.surfaces, n, w.lights);
  }
  clock.Lap(Stage::kEvaluate);
}

void SplatConnections(const FrameView& frame, std::uint32_t bounce, Worker& w, Film& film,
                      StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const RayKeys keys = MakeRayKeys(frame, w.paths, w.surfaces->path, n,
                                   LightPair(bounce, SampleUse::kLight), w.scratch);
  TraceLights(frame, ShadowTarget::kCamera, keys, w, clock);
  film.AddSplats(w.lights, w.of<LightPathTables>().cameras->pixel, n,
                 float(1 / double(frame.light_paths())), w.stats);
  clock.Lap(Stage::kFilm);
}

}  // namespace skywave
