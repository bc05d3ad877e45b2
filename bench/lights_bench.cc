// Times the building of the light strategies' tables on a map with a sun.

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "lights/light_sets/clustering.h"
#include "lights/light_sets/median_cut.h"
#include "lights/light_sets/penrose.h"
#include "lights/light_sets/strata.h"
#include "lights/light_sets/variance_cut.h"
#include "lights/light_sets/voronoi.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/cells.h"

namespace skywave {
namespace {

// Returns a smooth sky and ground, texture over two orders of magnitude, and a sun of 3 x 3 texels.
const Image& TestMap(int width) {
  static Image image;
  if (image.width == width) return image;
  image = Image(width, width / 2);
  std::mt19937 random(1);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float sky = y < image.height / 2 ? 1.0f : 0.2f;
      const float texture = std::exp(2 * std::sin(30.0f * x / width) * std::sin(23.0f * y / width));
      const float noise = 0.5f + float(random()) * 0x1p-32f;
      float* rgb = image.Pixel(x, y);
      rgb[0] = rgb[1] = rgb[2] = sky * texture * noise;
    }
  }
  for (int i = 0; i < 9; ++i) {
    float* rgb = image.Pixel(width / 3 + i % 3, image.height / 4 + i / 3);
    rgb[0] = rgb[1] = rgb[2] = 5e3f * float(width) / 1024 * float(width) / 1024;
  }
  return image;
}

std::vector<Vector3> TestSamples(const SphereMap& map, int count) {
  return Directions(PenroseSamples(ImportancePyramid(map), count));
}

void BM_SphereMap(benchmark::State& state) {
  const Image& image = TestMap(int(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(MakeSphereMap(image));
}
BENCHMARK(BM_SphereMap)->Arg(1024)->Arg(8192)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_MaxPyramid(benchmark::State& state) {
  const SphereMap map = MakeSphereMap(TestMap(int(state.range(0))));
  for (auto _ : state) benchmark::DoNotOptimize(ImportancePyramid(map));
}
BENCHMARK(BM_MaxPyramid)->Arg(1024)->Arg(8192)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_Penrose(benchmark::State& state) {
  const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(TestMap(int(state.range(0)))));
  for (auto _ : state) benchmark::DoNotOptimize(PenroseSamples(pyramid, int(state.range(1))));
}
BENCHMARK(BM_Penrose)
    ->Args({1024, 64})
    ->Args({1024, 3000})
    ->Args({1024, 20000})
    ->Args({8192, 3000})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_Voronoi(benchmark::State& state) {
  const int width = int(state.range(0));
  const SphereMap map = MakeSphereMap(TestMap(width));
  const std::vector<Vector3> samples = TestSamples(map, int(state.range(1)));
  for (auto _ : state) benchmark::DoNotOptimize(VoronoiCells(width, width / 2, samples));
}
BENCHMARK(BM_Voronoi)
    ->Args({1024, 64})
    ->Args({1024, 3000})
    ->Args({1024, 20000})
    ->Args({8192, 3000})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_VoronoiUniform(benchmark::State& state) {
  const int width = int(state.range(0));
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<Vector3> samples;
  for (int i = 0; i < 3000; ++i) {
    samples.push_back(NormalizeOr({normal(random), normal(random), normal(random)}, 0, {}));
  }
  for (auto _ : state) benchmark::DoNotOptimize(VoronoiCells(width, width / 2, samples));
}
BENCHMARK(BM_VoronoiUniform)->Arg(1024)->Arg(8192)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_LightsOfCells(benchmark::State& state) {
  const SphereMap map = MakeSphereMap(TestMap(int(state.range(0))));
  const std::vector<Vector3> samples = TestSamples(map, 3000);
  const CellMap cells = VoronoiCells(map.width, map.height, samples);
  for (auto _ : state) {
    benchmark::DoNotOptimize(LightsOfCells(map, cells, samples, LightPosition::kCentroid));
  }
}
BENCHMARK(BM_LightsOfCells)->Arg(1024)->Arg(8192)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_MedianCut(benchmark::State& state) {
  const SphereMap map = MakeSphereMap(TestMap(int(state.range(0))));
  for (auto _ : state) benchmark::DoNotOptimize(MedianCut(map, int(state.range(1))));
}
BENCHMARK(BM_MedianCut)
    ->Args({1024, 64})
    ->Args({1024, 3000})
    ->Args({8192, 3000})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_VarianceCut(benchmark::State& state) {
  const SphereMap map = MakeSphereMap(TestMap(int(state.range(0))));
  for (auto _ : state) benchmark::DoNotOptimize(VarianceCut(map, int(state.range(1))));
}
BENCHMARK(BM_VarianceCut)
    ->Args({1024, 64})
    ->Args({1024, 3000})
    ->Args({8192, 3000})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_StrataByVariation(benchmark::State& state) {
  const SphereMap map = MakeSphereMap(TestMap(int(state.range(0))));
  for (auto _ : state) benchmark::DoNotOptimize(StrataByVariation(map));
}
BENCHMARK(BM_StrataByVariation)->Arg(1024)->Arg(8192)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_Clustering(benchmark::State& state) {
  const SphereMap map = MakeSphereMap(TestMap(1024));
  const int count = int(state.range(0));
  const std::vector<Vector3> samples = TestSamples(map, count);
  const auto cells = SumCells(map, VoronoiCells(map.width, map.height, samples), samples.size());
  const auto frequencies = Frequencies(cells, ClusterFrequency(state.range(1)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(ClusterPairwise(samples, frequencies, {.clusters = count / 4}));
  }
}
BENCHMARK(BM_Clustering)
    ->Args({1000, 0})
    ->Args({3000, 0})
    ->Args({3000, 1})
    ->Args({3000, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// Builds all tables of a strategy with its defaults, including the packed map.
void BM_Strategy(benchmark::State& state, const std::string& name) {
  const EnvironmentMap map = {TestMap(int(state.range(0))),
                              {1, 0, 0, 0, 1, 0, 0, 0, 1},
                              {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}}};
  for (auto _ : state) benchmark::DoNotOptimize(MakeStrategy(name, map));
}

void RegisterStrategies() {
  for (const StrategyFactory& strategy : Strategies()) {
    const std::string name(strategy.name);
    benchmark::RegisterBenchmark(("BM_Strategy/" + name).c_str(), BM_Strategy, name)
        ->Arg(1024)
        ->Arg(8192)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
}

}  // namespace
}  // namespace skywave

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  skywave::RegisterStrategies();
  benchmark::RunSpecifiedBenchmarks();
}
