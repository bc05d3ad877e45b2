// Compares the engine with the tests' oracle, a plain depth-first path tracer
// (tests/support/oracle.h), on built-in scenes with equal threads: the ratio shows the benefit of
// the wavefront. Each iteration renders once with each, so that a slow minute affects both;
// counters are medians over the iterations, and the ratio is taken per pair.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/granted.h"
#include "job/job.h"
#include "scene/builtin/builtin.h"
#include "tests/support/oracle.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

void Floor(benchmark::State& state, const std::string& name) {
  const char* const wish = std::getenv("SKYWAVE_BENCH_THREADS");
  Scene scene = BuiltinScene(name);
  JobRequest request;
  request.scene = name;
  request.width = 320, request.height = 240;
  request.samples_per_pixel = 16;
  request.options.threads = wish != nullptr ? std::stoi(wish) : GrantedHere().threads;
  const Oracle oracle(scene);
  const RenderJob job(std::move(scene), request);
  const double samples =
      double(job.options().width) * job.options().height * job.options().samples_per_pixel;

  std::vector<double> engine_rate, oracle_rate, ratio;
  for (auto _ : state) {
    Film film = job.MakeFilm();
    const double engine_seconds = RenderFrame(job.frame(), film).seconds;
    const double oracle_seconds = oracle.Render(job.options()).seconds;
    engine_rate.push_back(samples / engine_seconds * 1e-6);
    oracle_rate.push_back(samples / oracle_seconds * 1e-6);
    ratio.push_back(oracle_seconds / engine_seconds);
    state.SetIterationTime(engine_seconds);
  }
  state.counters["engine_Msamples"] = Median(engine_rate);
  state.counters["oracle_Msamples"] = Median(oracle_rate);
  state.counters["ratio"] = Median(ratio);
  state.counters["ratio_min"] = *std::min_element(ratio.begin(), ratio.end());
  state.counters["ratio_max"] = *std::max_element(ratio.begin(), ratio.end());
  state.counters["threads"] = request.options.threads;
}

constexpr int kPairs = 9;
BENCHMARK_CAPTURE(Floor, gallery, "gallery")->Iterations(kPairs)->UseManualTime();
BENCHMARK_CAPTURE(Floor, spheres, "spheres")->Iterations(kPairs)->UseManualTime();
BENCHMARK_CAPTURE(Floor, many_shapes, "many-shapes")->Iterations(kPairs)->UseManualTime();

}  // namespace
}  // namespace skywave

BENCHMARK_MAIN();
