// Measures photon maps: photons traced, trees built and queries answered per second
// (photon_scaling_bench.cc compares one thread with several).
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>

#include "bench/photon_points.h"
#include "job/job.h"
#include "scene/builtin/builtin.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/records/photon_map.h"

namespace skywave {
namespace {

const PointTree& KeptTree(std::size_t count, bool caustic) {
  static std::map<std::pair<std::size_t, bool>, PointTree> trees;
  const auto [at, fresh] = trees.try_emplace({count, caustic});
  if (fresh) {
    at->second = TreeOf(MakePoints(count, caustic, 1));
  }
  return at->second;
}

// Returns the radius of a disk that holds `neighbors` of `count` photons spread evenly over six
// sides.
float EvenRadius(std::size_t count, std::uint32_t neighbors) {
  return std::sqrt(6 * float(neighbors) / (3.14159265f * float(count)));
}

constexpr std::uint32_t kQueries = 16384, kBlock = 16;

void BuildTree(benchmark::State& state) {
  const auto count = std::size_t(state.range(0));
  const Points points = MakePoints(count, false, 1);
  tbb::task_arena arena(int(state.range(1)));
  for (auto _ : state) {
    arena.execute([&] {
      const PointTree tree = TreeOf(points);
      benchmark::DoNotOptimize(tree.view().nodes);
    });
  }
  state.SetItemsProcessed(std::int64_t(state.iterations() * count));
}
BENCHMARK(BuildTree)
    ->ArgNames({"photons", "threads"})
    ->ArgsProduct({{100000, 1000000, 10000000}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void Nearest(benchmark::State& state) {
  const auto count = std::size_t(state.range(0));
  const auto neighbors = std::uint32_t(state.range(1));
  const bool caustic = state.range(2) != 0;
  const PointTree& tree = KeptTree(count, caustic);
  const Points queries = MakePoints(kQueries, caustic, 2);
  const float radius = 3 * EvenRadius(count, neighbors);
  const soa::Table<NeighborColumns> found(kBlock * NearestRoom(neighbors));
  std::uint32_t counts[kBlock];
  for (auto _ : state) {
    for (std::uint32_t i = 0; i < kQueries; i += kBlock) {
      FindNearest(tree.view(), &queries.axes[0][i], &queries.axes[1][i], &queries.axes[2][i],
                  kBlock, neighbors, radius * radius, found, counts);
    }
  }
  state.SetItemsProcessed(std::int64_t(state.iterations()) * kQueries);
}
BENCHMARK(Nearest)
    ->ArgNames({"photons", "neighbors", "caustic"})
    ->ArgsProduct({{100000, 1000000, 10000000}, {50, 100}, {0, 1}});

void Range(benchmark::State& state) {
  const auto count = std::size_t(state.range(0));
  const PointTree& tree = KeptTree(count, false);
  const Points queries = MakePoints(kQueries, false, 2);
  const float radius = EvenRadius(count, std::uint32_t(state.range(1)));
  constexpr std::uint32_t kRoom = 256;
  const soa::Table<NeighborColumns> found(kRoom);
  std::int64_t sum = 0;
  for (auto _ : state) {
    for (std::uint32_t i = 0; i < kQueries; ++i) {
      const float query[3] = {queries.axes[0][i], queries.axes[1][i], queries.axes[2][i]};
      RangeSearch search = StartRangeSearch(tree.view(), query, radius * radius);
      while (const std::uint32_t more = FindMore(tree.view(), search, kRoom, found)) sum += more;
    }
  }
  benchmark::DoNotOptimize(sum);
  state.SetItemsProcessed(std::int64_t(state.iterations()) * kQueries);
}
BENCHMARK(Range)
    ->ArgNames({"photons", "neighbors"})
    ->ArgsProduct({{100000, 1000000, 10000000}, {50}});

// Runs the first pass of a frame, trees included; an item is a stored photon.
void TracePass(benchmark::State& state, const char* scene) {
  JobRequest request;
  request.integrator = Integrator::kPhoton;
  request.options.threads = int(state.range(0));
  request.options.of<PhotonOptions>().indirect = 400000;
  const RenderJob job(BuiltinScene(scene), request);
  const FrameView frame = job.frame();
  const PhotonPass pass = PhotonPasses(frame.options).front();
  std::int64_t photons = 0, light_paths = 0;
  for (auto _ : state) {
    WorkerPool pool(frame.options);
    pool.Run([&] {
      const PhotonMaps maps = TracePhotons(frame, pass, pool);
      photons += maps.caustic.size() + maps.indirect.size();
      light_paths +=
          std::int64_t(std::max(maps.caustic.light_paths(), maps.indirect.light_paths()));
    });
  }
  state.SetItemsProcessed(photons);
  state.counters["light_paths/s"] =
      benchmark::Counter(double(light_paths), benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(TracePass, lamps, "lamps")->ArgName("threads")->Arg(1)->Arg(2)->UseRealTime();
BENCHMARK_CAPTURE(TracePass, three_spheres, "three-spheres")
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime();

}  // namespace
}  // namespace skywave

BENCHMARK_MAIN();
