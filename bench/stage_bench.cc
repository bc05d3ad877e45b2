// Measures every stage and the kernels inside it on one wave of a real scene: ns per item (input
// row).
#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "bench/wave_fixture.h"
#include "kernels/accumulate.h"
#include "kernels/camera.h"
#include "kernels/lights/environment.h"
#include "kernels/sampler.h"
#include "kernels/surface/layers.h"
#include "kernels/surface/surface.h"
#include "scene/builtin/builtin.h"
#include "scene/geometry.h"
#include "scene/shapes/shapes.h"

namespace skywave {
namespace {

WaveFixture& CameraWave() {
  static WaveFixture wave;
  return wave;
}
struct BouncedFixture : WaveFixture {
  BouncedFixture() { Bounce(); }
};
WaveFixture& BounceWave() {
  static BouncedFixture wave;
  return wave;
}

// Runs `body` and reports the time per item.
template <class Body>
void Run(benchmark::State& state, std::uint32_t items, Body body) {
  const auto start = std::chrono::steady_clock::now();
  for (auto _ : state) body();
  const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
  state.counters["ns_per_item"] = elapsed.count() / (double(state.iterations()) * items);
  state.counters["items"] = items;
}

void GenerateStage(benchmark::State& state) {
  WaveFixture& f = CameraWave();
  Worker& w = f.worker;
  const FilmUniforms film(w.scratch);
  const LensUniforms lens(w.scratch);
  Run(state, f.n, [&] { GenerateRays(f.frame, f.range, film, lens, w.paths, w.rays[1]); });
}
void DrawUniformsKernel(benchmark::State& state) {
  WaveFixture& f = CameraWave();
  const LightUniforms uniforms(f.worker.scratch);
  Run(state, f.n, [&] { DrawUniforms(f.worker.paths, nullptr, f.n, 3, {}, uniforms); });
}
void DrawUniformsOfRowsKernel(benchmark::State& state) {
  WaveFixture& f = CameraWave();
  const std::uint32_t n = f.ranges.total();
  const LightUniforms uniforms(f.worker.scratch);
  Run(state, n, [&] { DrawUniforms(f.worker.paths, f.worker.surfaces->path, n, 3, {}, uniforms); });
}
void GenerateCameraRaysKernel(benchmark::State& state) {
  WaveFixture& f = CameraWave();
  Worker& w = f.worker;
  const FilmUniforms film(w.scratch);
  const LensUniforms lens(w.scratch);
  DrawUniforms(w.paths, nullptr, f.n, kFilmPair, {}, film);
  DrawUniforms(w.paths, nullptr, f.n, kLensPair, {}, lens);
  Run(state, f.n, [&] { GenerateCameraRays(f.frame.camera, w.paths, film, lens, f.n, w.rays[1]); });
}
// With `beams`, camera rays are traced as beams, whatever the backend; otherwise the backend traces
// them like other rays.
void TraceClosestStage(benchmark::State& state, bool bounce, bool beams, Backend backend) {
  WaveFixture& f = bounce ? BounceWave() : CameraWave();
  const RayColumns& rays = f.worker.rays[0];
  Tracer tracer = f.frame.tracer;
  tracer.beams = beams;
  tracer.closest = backend;
  const RayKeys keys =
      MakeRayKeys(f.frame, f.worker.paths, rays.path, f.n,
                  SamplePair(bounce ? 1 : 0, SampleUse::kScatter), f.worker.scratch);
  Run(state, f.n, [&] {
    std::fill_n(rays.t_far, f.n, std::numeric_limits<float>::infinity());
    TraceClosest(tracer, bounce ? RayKind::kBounce : RayKind::kCamera, rays, f.n, f.worker.hits,
                 keys->key);
  });
}
void SortHitsStage(benchmark::State& state, bool bounce) {
  WaveFixture& f = bounce ? BounceWave() : CameraWave();
  Worker& w = f.worker;
  const RayQueues queues(w.scratch);
  Run(state, f.n, [&] {
    SurfaceRanges ranges;
    benchmark::DoNotOptimize(
        SortHits(*f.frame.geometry, w.rays[0], w.hits, f.n, false, queues, ranges));
  });
}
void MoveEscapedKernel(benchmark::State& state) {
  WaveFixture& f = BounceWave();
  Worker& w = f.worker;
  const RayQueues queues = f.Sort();
  Run(state, f.n, [&] { MoveEscaped(w.rays[0], queues->queue, f.n, w.escaped); });
}
void MoveSurfacesStage(benchmark::State& state) {
  static BouncedFixture f;  // a separate fixture because the surfaces that the rays have left are
                            // overwritten
  Worker& w = f.worker;
  const RayQueues queues = f.Sort();
  Run(state, f.n, [&] {
    MoveSurfaces(*f.frame.geometry, w.rays[0], w.hits, queues, f.n, f.ranges, w.surfaces);
  });
}
void AddEscapedStage(benchmark::State& state, bool bounce) {
  WaveFixture& f = bounce ? BounceWave() : CameraWave();
  if (f.escaped == 0) return state.SkipWithError("no ray escapes");
  Run(state, f.escaped, [&] {
    AddEscaped(f.frame, f.Points(), nullptr, f.worker.escaped, f.escaped, f.worker.paths);
  });
}
void PrepareSurfacesKernel(benchmark::State& state) {
  static WaveFixture f;  // a separate fixture because the kernel works in place
  Run(state, f.ranges.total(), [&] {
    PrepareSurfaces(f.frame.geometry->triangle_tables(), f.frame.geometry->materials().records,
                    f.ranges.total(), f.worker.surfaces);
  });
}
// There is nothing to do if the scene has neither textures nor metallic-roughness.
void TextureSurfacesStage(benchmark::State& state) {
  static WaveFixture f;
  Run(state, f.ranges.total(),
      [&] { TextureSurfaces(f.frame, kCameraEnd, f.ranges, f.worker.surfaces); });
}
// Measures a fixed sample of the plan (one light, one cell), or a drawn one.
void SampleLightsStage(benchmark::State& state, const std::string& strategy, bool fixed) {
  WaveFixture f(strategy);
  Worker& w = f.worker;
  const LightShares shares = f.shares();
  const LightPlan& plan = shares.plan;
  if ((fixed ? plan.fixed : plan.drawn) == 0) return state.SkipWithError("not in its plan");
  const LightUniforms uniforms(w.scratch);
  const LightPlaces places(w.hits);
  Run(state, f.ranges.light_sampled(), [&] {
    SampleLights(f.frame, f.Points(), shares, SamplePair(0, SampleUse::kLight),
                 fixed ? 0 : plan.fixed, uniforms, w.scratch, w.lights, places);
  });
}
void EvaluateLightsStage(benchmark::State& state) {
  static WaveFixture f;
  const LightReach reach = f.SampleAndEvaluate(0);
  Run(state, f.ranges.light_sampled(),
      [&] { EvaluateLights(f.frame, f.worker.surfaces, f.ranges, reach, 0, f.worker.lights); });
}
void TraceShadowsStage(benchmark::State& state, Backend backend) {
  static WaveFixture f;
  Worker& w = f.worker;
  const std::uint32_t n = f.ranges.light_sampled();
  f.SampleAndEvaluate(0);
  const std::vector<float> t_far(w.lights->t_far, w.lights->t_far + n);
  Tracer tracer = f.frame.tracer;
  tracer.occlusion = backend;
  Run(state, n, [&] {
    std::copy(t_far.begin(), t_far.end(), w.lights->t_far);
    TraceShadows(tracer, w.surfaces, n, w.lights);
  });
}
void AddUnoccludedKernel(benchmark::State& state) {
  static WaveFixture f;
  Worker& w = f.worker;
  const std::uint32_t n = f.ranges.light_sampled();
  f.SampleAndEvaluate(0);
  TraceShadows(f.frame.tracer, w.surfaces, n, w.lights);
  Run(state, n, [&] { AddUnoccludedRadiance(w.lights, w.surfaces->path, n, w.paths); });
}
void ScatterStage(benchmark::State& state) {
  WaveFixture& f = CameraWave();
  Worker& w = f.worker;
  Run(state, f.ranges.total(), [&] {
    Scatter(f.frame, PointsIn(f.ranges, f.frame, w), {kCameraEnd, 0}, w.scratch, w.rays[1]);
  });
}
void FilmStage(benchmark::State& state) {
  WaveFixture& f = CameraWave();
  Run(state, f.n, [&] { f.film.Add(f.worker.paths, f.n, f.worker.stats); });
}
void PathWave(benchmark::State& state) {
  static WaveFixture f;
  Run(state, f.range.count, [&] { RenderPathWave(f.frame, f.range, f.worker, f.film); });
}

// Returns one material for each BSDF: those of the scene "materials" and a measured one with a
// single value.
const Geometry& MaterialsOfAll() {
  static const Geometry geometry = [] {
    Scene scene = BuiltinScene("materials");
    scene.measured.push_back(
        {.rgb = std::vector<float>(kMeasuredFloats, 0.2f), .alpha = 0.3f, .specular_share = 0.5f});
    scene.materials.push_back({.bsdf = BsdfKind::kMeasured, .reflectance = glm::vec3(1)});
    scene.meshes.push_back(Quad(1));
    scene.meshes.back().material = std::uint32_t(scene.materials.size() - 1);
    return Geometry(scene, "materials", 1);
  }();
  return geometry;
}

// Gives every surface of the wave a material of BSDF `kind`.
void PaintWave(WaveFixture& f, std::uint32_t kind) {
  const Geometry& geometry = MaterialsOfAll();
  const auto of_kind = [&](const TriangleRecord& t) {
    return (t.tag & kMixedTriangle) == 0 && t.tag >> kKindShift == kind;
  };
  const TriangleRecord* const end = geometry.triangles() + geometry.triangle_count();
  const TriangleRecord* const found = std::find_if(geometry.triangles(), end, of_kind);
  const std::uint32_t material = found == end ? 0 : found->tag & kMaterialMask;
  const MaterialRecord& record = geometry.materials().records[material];
  const bool tangent = Bsdfs()[kind].varying == Varying::kTangent;
  const SurfaceColumns& s = f.worker.surfaces;
  for (std::uint32_t i = 0; i < f.ranges.total(); ++i) {
    s.material[i] = material;
    s.varying_0[i] = tangent ? 1 : record.alpha;
    s.varying_1[i] = tangent ? 0 : record.eta[0];
  }
  if (Bsdfs()[kind].varying == Varying::kLayers) {
    PrepareLayers({}, geometry.materials().records, nullptr, 0, f.ranges.total(), s);
  }
}

// Shades every surface of the camera wave with BSDF `kind`; light samples and scattering are
// measured separately.
void BsdfEvaluate(benchmark::State& state, std::uint32_t kind) {
  static WaveFixture f;
  Worker& w = f.worker;
  const std::uint32_t n = f.ranges.total();
  PaintWave(f, kind);
  const LightUniforms uniforms(w.scratch);
  DrawUniforms(w.paths, w.surfaces->path, n, 1, {}, uniforms);
  f.frame.strategy->Sample(f.Points(), uniforms, n, {}, w.lights);
  Run(state, n, [&] {
    Bsdfs()[kind].evaluate_lights(w.surfaces, MaterialsOfAll().materials(), n, f.frame.mis(),
                                  w.lights);
  });
}
void BsdfScatter(benchmark::State& state, std::uint32_t kind) {
  static WaveFixture f;
  Worker& w = f.worker;
  const std::uint32_t n = f.ranges.total();
  PaintWave(f, kind);
  const DirectionUniforms direction(w.scratch);
  const LobeUniforms lobe(w.scratch);
  DrawUniforms(w.paths, w.surfaces->path, n, 2, {}, direction);
  DrawUniforms(w.paths, w.surfaces->path, n, 3, {}, lobe);
  Run(state, n, [&] {
    Bsdfs()[kind].scatter(w.surfaces, MaterialsOfAll().materials(),
                          {.direction = direction, .lobe = lobe}, n, {}, w.rays[1], 0);
  });
}

void Register() {
  const auto add = [](const std::string& name, auto function, auto... values) {
    benchmark::RegisterBenchmark(name.c_str(), function, values...);
  };
  add("stage/generate", GenerateStage);
  add("kernel/draw_uniforms", DrawUniformsKernel);
  add("kernel/draw_uniforms_of_rows", DrawUniformsOfRowsKernel);
  add("kernel/camera_rays", GenerateCameraRaysKernel);
  add("stage/intersect/camera/beams", TraceClosestStage, false, true, Backend::kBest);
  for (const Backend backend : kBackends) {
    const std::string name(ToString(backend));
    add("stage/intersect/camera/" + name, TraceClosestStage, false, false, backend);
    add("stage/intersect/bounce/" + name, TraceClosestStage, true, true, backend);
    add("stage/shadow/" + name, TraceShadowsStage, backend);
  }
  add("stage/sort_hits/camera", SortHitsStage, false);
  add("stage/sort_hits/bounce", SortHitsStage, true);
  add("kernel/move_escaped", MoveEscapedKernel);
  add("stage/move_surfaces", MoveSurfacesStage);
  add("stage/escape/camera", AddEscapedStage, false);
  add("stage/escape/bounce", AddEscapedStage, true);
  add("kernel/prepare_surfaces", PrepareSurfacesKernel);
  add("stage/texture_surfaces", TextureSurfacesStage);
  for (const StrategyFactory& strategy : Strategies()) {
    const std::string name(strategy.name);
    add("stage/light_sample/" + name + "/fixed", SampleLightsStage, name, true);
    add("stage/light_sample/" + name + "/drawn", SampleLightsStage, name, false);
  }
  add("stage/evaluate", EvaluateLightsStage);
  add("kernel/add_unoccluded", AddUnoccludedKernel);
  add("stage/scatter", ScatterStage);
  for (std::uint32_t kind = 0; kind < kBsdfKinds; ++kind) {
    const std::string name(Bsdfs()[kind].name);
    if (!Bsdfs()[kind].delta) add("kernel/evaluate_lights/" + name, BsdfEvaluate, kind);
    add("kernel/scatter/" + name, BsdfScatter, kind);
  }
  add("stage/film", FilmStage);
  add("wave/path", PathWave);
}

// Restricts the kernels to one instruction set by its name in Highway; empty: the best available.
bool ChooseTarget(const std::string& name) {
  if (name.empty()) return true;
  const std::int64_t supported = hwy::SupportedTargets();
  for (std::int64_t rest = supported; rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    if (name != hwy::TargetName(target)) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return true;
  }
  std::fprintf(stderr, "SKYWAVE_BENCH_TARGET=%s: this processor has not got it\n", name.c_str());
  return false;
}

}  // namespace
}  // namespace skywave

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  if (!skywave::ChooseTarget(skywave::Variable("SKYWAVE_BENCH_TARGET", ""))) return 1;
  skywave::Register();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
