// The denoiser's time per pixel, on pictures of noise, without and with surfaces that differ.
// Google Benchmark; one argument is the width of the picture, whose height is three quarters of it.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <random>
#include <vector>

#include "job/denoise/denoise.h"

namespace skywave {
namespace {

// Layers of a picture of 16 samples, of stripes that differ in normals.
struct Picture {
  Image image;
  std::vector<NamedChannel> layers;
};

Picture MakePicture(int width, int stripe) {
  const int height = width * 3 / 4;
  const std::size_t pixels = std::size_t(width) * std::size_t(height);
  std::mt19937 random(1);
  std::normal_distribution<float> noise(1, 0.2f);
  Picture picture = {Image(width, height), {}};
  for (float& value : picture.image.rgb) value = noise(random);
  for (const std::string& name : DenoiserChannels()) {
    float value = 1;
    if (name == "samples.V") value = 16;
    if (name == "half.N") value = 8;
    if (name.find("variance") != std::string::npos) value = 0.6f;
    picture.layers.push_back({name, std::vector<float>(pixels, value)});
    std::vector<float>& values = picture.layers.back().values;
    if (name == "shading-normal.X") {
      for (std::size_t i = 0; i < pixels; ++i) {
        values[i] = float(int(i % std::size_t(width)) / stripe % 2);
      }
    }
  }
  for (const std::size_t c : {0, 1, 2}) {
    for (NamedChannel& layer : picture.layers) {
      if (layer.name != std::string("half.") + "RGB"[c]) continue;
      for (std::size_t i = 0; i < pixels; ++i) layer.values[i] = picture.image.rgb[3 * i + c];
    }
  }
  return picture;
}

void BM_Denoise(benchmark::State& state) {
  const Picture picture = MakePicture(int(state.range(0)), int(state.range(1)));
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(state.range(2)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        Denoise(Denoiser::kStatistics, "bench", picture.image, picture.layers));
  }
  state.counters["ns/pixel"] =
      benchmark::Counter(double(state.iterations()) * double(picture.image.rgb.size()) / 3,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(BM_Denoise)
    ->ArgNames({"width", "stripe", "threads"})
    ->Args({640, 4, 1})
    ->Args({640, 100000, 1})
    ->Args({640, 100000, 2})
    ->Args({1920, 100000, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace skywave

BENCHMARK_MAIN();
