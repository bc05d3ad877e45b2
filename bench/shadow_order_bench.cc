// Traces shadow rays of directional lights in two orders: all surfaces of a wave towards one light,
// then the next light (the order of the integrators), or all lights of a surface, then the next
// surface. The rays are the same, in streams of the same length. SKYWAVE_BENCH_* choose scene and
// map.
#include <benchmark/benchmark.h>

#include <limits>
#include <vector>

#include "bench/wave_fixture.h"

namespace skywave {
namespace {

constexpr std::uint32_t kLights = 64;

// The open shadow rays of one wave, in both orders.
struct ShadowRays {
  ShadowRays() : wave("penrose:lights=" + std::to_string(kLights)) {
    Worker& w = wave.worker;
    const std::uint32_t n = wave.ranges.light_sampled();
    const LightShares shares = wave.shares();
    const LightPlan& plan = shares.plan;
    std::vector<std::vector<Vector>> directions(plan.fixed, std::vector<Vector>(n));
    std::vector<std::vector<bool>> open(plan.fixed, std::vector<bool>(n));
    for (std::uint32_t light = 0; light < plan.fixed; ++light) {
      wave.SampleAndEvaluate(light);
      for (std::uint32_t i = 0; i < n; ++i) {
        directions[light][i] = {w.lights->dir_x[i], w.lights->dir_y[i], w.lights->dir_z[i]};
        open[light][i] = w.lights->t_far[i] >= 0;
      }
    }
    light_major = soa::Table<RayColumns>(n * plan.fixed);
    point_major = soa::Table<RayColumns>(n * plan.fixed);
    std::uint32_t rows = 0;
    const auto add = [&](const RayColumns& rays, std::uint32_t light, std::uint32_t i) {
      if (!open[light][i]) return;
      rays.org_x[rows] = w.surfaces->org_x[i];
      rays.org_y[rows] = w.surfaces->org_y[i];
      rays.org_z[rows] = w.surfaces->org_z[i];
      rays.dir_x[rows] = directions[light][i].x;
      rays.dir_y[rows] = directions[light][i].y;
      rays.dir_z[rows] = directions[light][i].z;
      ++rows;
    };
    for (std::uint32_t light = 0; light < plan.fixed; ++light) {
      for (std::uint32_t i = 0; i < n; ++i) add(light_major, light, i);
    }
    count = rows;
    rows = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      for (std::uint32_t light = 0; light < plan.fixed; ++light) add(point_major, light, i);
    }
  }
  struct Vector {
    float x, y, z;
  };
  WaveFixture wave;
  soa::Table<RayColumns> light_major, point_major;
  std::uint32_t count = 0;
};

ShadowRays& Rays() {
  static ShadowRays rays;
  return rays;
}

void Trace(benchmark::State& state, const RayColumns& rays) {
  const ShadowRays& shadows = Rays();
  const std::uint32_t stream = shadows.wave.worker.paths.rows();
  for (auto _ : state) {
    for (std::uint32_t begin = 0; begin < shadows.count; begin += stream) {
      const std::uint32_t n = std::min(stream, shadows.count - begin);
      const RayColumns slice = Slice(rays, begin);
      std::fill_n(slice.t_far, n, std::numeric_limits<float>::infinity());
      TraceOcclusion(shadows.wave.frame.tracer, slice, n);
    }
  }
  state.counters["ns_per_ray"] = benchmark::Counter(
      double(shadows.count) * 1e-9,
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["rays"] = shadows.count;
}
void LightMajor(benchmark::State& state) { Trace(state, Rays().light_major); }
void PointMajor(benchmark::State& state) { Trace(state, Rays().point_major); }
BENCHMARK(LightMajor)->UseRealTime();
BENCHMARK(PointMajor)->UseRealTime();

}  // namespace
}  // namespace skywave

BENCHMARK_MAIN();
