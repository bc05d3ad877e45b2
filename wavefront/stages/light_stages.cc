#include "wavefront/stages/light_stages.h"

#include <algorithm>

#include "kernels/light_paths/bidirectional.h"
#include "kernels/light_paths/flux.h"
#include "kernels/lights/directional.h"
#include "kernels/sampler.h"
#include "wavefront/guiding/emission_guide.h"
#include "wavefront/stages/checks.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

constexpr std::uint32_t LightPair(std::uint32_t bounce, SampleUse use) {
  return kLightEnd.pairs + SamplePair(bounce, use);
}

// What surfaces send towards the camera: w.light->values, for directions in w.lights.
void EvaluateConnections(const FrameView& frame, Worker& w) {
  const MaterialView materials = frame.geometry->materials();
  for (std::uint32_t kind = 0; kind < kFirstDeltaBsdf; ++kind) {
    const std::uint32_t n = w.ranges.count(kind), begin = w.ranges.begin[kind];
    if (n == 0) continue;
    const BsdfKernels& bsdf = Bsdfs()[kind];
    const SurfaceColumns surfaces = Slice(w.surfaces.columns(), begin);
    const LightColumns lights = Slice(w.lights.columns(), begin);
    const NormalColumns normals = Slice(w.light->normals.columns(), begin);
    SurfaceColumns seen = surfaces;
    seen.ns_x = normals.x, seen.ns_y = normals.y, seen.ns_z = normals.z;
    FaceNormals(surfaces, lights, n, normals);
    const BsdfValueColumns values = Slice(w.light->values.columns(), begin);
    bsdf.evaluate(seen, materials, lights, n, values);
    MakeFlux(bsdf, seen, materials, lights, n, values);
    ClearUnseen(seen, n, values);
    if (bsdf.transmits) MoveToSide(lights, n, surfaces);
  }
}

// Where the sky's directions were not drawn by the strategy, it is asked how it would have.
void GuideDistantRays(const FrameView& frame, const LightShares& shares, std::uint32_t n,
                      const RayColumns& rays, const Worker& w) {
  const float* light_pdf = nullptr;
  if (frame.guide->directions) {
    EscapeColumns seen = w.escaped;
    seen.dir_x = w.lights->dir_x, seen.dir_y = w.lights->dir_y, seen.dir_z = w.lights->dir_z;
    std::fill_n(seen.pdf, n, 1.0f);
    frame.strategy->EvaluateEscaped(Points(frame, w), n, shares.of_strategy, seen);
    light_pdf = seen.light_pdf;
  }
  GuideStarts(frame.sphere, GuideOf(frame), w.lobe, light_pdf, n, rays, w.light->emission);
}

}  // namespace

void StartLightPaths(const RenderOptions& options, std::uint64_t first, std::uint32_t n,
                     const PathColumns& paths) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint64_t number = first + i;
    // A sequence has 2^32 points. No pixel of a film has that place.
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
  const std::uint32_t pair = LightPair(0, SampleUse::kLight);
  DrawUniforms(w.paths, nullptr, n, pair, {}, w.uniforms);
  if (shares.local.share < 1) {
    UniformColumns of_strategy = w.uniforms;
    if (shares.local.share > 0) {
      SplitUniforms(w.uniforms->u, n, shares.local.share, w.lobe->u);
      of_strategy.u = w.lobe->u;
    }
    const bool redrawn = frame.guide != nullptr && frame.guide->directions;
    const EnvStrategy& strategy = redrawn ? *frame.guide->directions : *frame.strategy;
    strategy.Sample(Points(frame, w), of_strategy, n, {.pair = pair, .share = shares.of_strategy},
                    w.lights);
    CheckLightSamples(w.lights, n);
  }
  DrawUniforms(w.paths, nullptr, n, LightPair(0, SampleUse::kScatter), {}, w.lobe);
  const EmissionColumns& emission = w.light->emission;
  if (shares.local.share < 1) {
    EmitFromEnvironment(frame.sphere, w.lights, w.lobe, n, rays, emission);
  }
  if (shares.local.share > 0) {
    EmitFromLocalLights(frame.local_lights, shares.local, frame.sphere, w.uniforms, w.lobe, n, rays,
                        emission, w.hits);
    if (frame.local_lights.has_alpha) {
      const std::uint32_t* const keys =
          RayKeys(frame, w.paths, rays.path, n, LightPair(0, SampleUse::kLobe), w.queue->queue);
      CloseTransparentSamples(frame, w.hits, keys, n, rays.t_far);
    }
  }
  if (frame.guide != nullptr) GuideDistantRays(frame, shares, n, rays, w);
  clock.Lap(Stage::kGenerate);
}

void IntersectLightPathSurfaces(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                                std::uint32_t bounce, Worker& w, StageClock& clock) {
  SurfaceRanges ranges;
  const std::uint32_t escaped =
      TraceAndSort(frame, kLightEnd, rays, n, bounce, /*only_delta=*/false, w, ranges, clock);
  PrepareHits(frame, kLightEnd, rays, n, escaped, ranges, w, clock);
}

void ConnectSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const CameraColumns& cameras = w.light->cameras;
  const std::uint32_t pair = LightPair(bounce, SampleUse::kLight);
  if (frame.camera.has_lens()) {
    DrawUniforms(w.paths, w.surfaces->path, n, pair + kPairBlock, {}, w.lobe);
  }
  ConnectCamera(frame.camera, w.surfaces, w.lobe, n, w.lights, cameras);
  DrawUniforms(w.paths, w.surfaces->path, n, pair, {}, w.uniforms);
  ChoosePixels(frame.camera, frame.filter, w.uniforms, n, w.lights, cameras);
  EvaluateConnections(frame, w);
  WeighConnections(w.surfaces, w.light->values, cameras, n, w.lights);
  clock.Lap(Stage::kEvaluate);
}

void SplatConnections(const FrameView& frame, std::uint32_t bounce, Worker& w, Film& film,
                      StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const std::uint32_t* const keys = RayKeys(frame, w.paths, w.surfaces->path, n,
                                            LightPair(bounce, SampleUse::kLight), w.queue->queue);
  TraceLights(frame, keys, w, clock);
  film.AddSplats(w.lights, w.light->cameras->pixel, n, float(1 / double(frame.light_paths())),
                 w.stats);
  clock.Lap(Stage::kFilm);
}

}  // namespace skywave
