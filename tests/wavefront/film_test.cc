// Tests the film's fixed-point sums: exact, independent of order, saturating, and counting bad
// samples.
#include "wavefront/film/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <thread>
#include <vector>

#include "kernels/light_paths/camera_connection.h"
#include "tests/support/random_rows.h"
#include "tests/support/targets.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint64_t kFull = std::numeric_limits<std::uint64_t>::max();

struct Sample {
  std::uint32_t pixel;
  float rgb[3];
};

// Adds samples [begin, end) in waves of `wave` rows.
void Add(const std::vector<Sample>& samples, std::size_t begin, std::size_t end, std::uint32_t wave,
         Film& film, RenderStats& stats) {
  const soa::Table<PathColumns> paths(wave);
  while (begin < end) {
    const auto n = std::uint32_t(std::min<std::size_t>(wave, end - begin));
    for (std::uint32_t i = 0; i < n; ++i, ++begin) {
      paths->pixel[i] = samples[begin].pixel;
      paths->r[i] = samples[begin].rgb[0];
      paths->g[i] = samples[begin].rgb[1];
      paths->b[i] = samples[begin].rgb[2];
    }
    film.Add(paths, n, stats);
  }
}
std::vector<std::uint64_t> Sums(const Film& film) {
  return {film.sums().begin(), film.sums().end()};
}

// Returns radiances over forty powers of two, some of them bad, with repeated pixels.
std::vector<Sample> WildSamples(std::size_t count, std::uint32_t pixels) {
  Random random(3);
  std::vector<Sample> samples(count);
  std::uint32_t pixel = 0;
  for (Sample& sample : samples) {
    if (random.Word() % 8 == 0) pixel = random.Word() % pixels;
    sample.pixel = pixel;
    for (float& value : sample.rgb) {
      value = float(std::exp2(random.Between(-30, 10)));
      switch (random.Word() % 64) {
        case 0:
          value = kNan;
          break;
        case 1:
          value = -value;
          break;
        case 2:
          value = kInfinity;
          break;
        case 3:
          value = 1e9f;
          break;
        case 4:
          value = 0;
          break;
        default:
          break;
      }
    }
  }
  return samples;
}

TEST(Film, SumsDoNotDependOnOrderWavesOrSplit) {
  constexpr std::uint32_t kPixels = 12;
  std::vector<Sample> samples = WildSamples(5000, kPixels);
  Film reference(4, 3, 100);
  RenderStats counted;
  Add(samples, 0, samples.size(), kFullWave, reference, counted);
  EXPECT_GT(counted.clamped_samples, 0u);
  EXPECT_GT(counted.invalid_samples, 0u);

  ForEachTarget([&] {
    for (const std::uint32_t wave : {1u, 2u, 17u, 256u, kFullWave}) {
      SCOPED_TRACE(wave);
      std::shuffle(samples.begin(), samples.end(), std::mt19937(wave));
      Film one(4, 3, 100), first(4, 3, 100), second(4, 3, 100);
      RenderStats stats, of_parts;
      Add(samples, 0, samples.size(), wave, one, stats);
      Add(samples, 0, 1234, wave, first, of_parts);
      Add(samples, 1234, samples.size(), wave, second, of_parts);
      second.Merge(first);
      EXPECT_EQ(Sums(one), Sums(reference));
      EXPECT_EQ(Sums(second), Sums(reference));
      for (const RenderStats* s : {&stats, &of_parts}) {
        EXPECT_EQ(s->samples, counted.samples);
        EXPECT_EQ(s->clamped_samples, counted.clamped_samples);
        EXPECT_EQ(s->invalid_samples, counted.invalid_samples);
      }
    }
  });
}

TEST(Film, SamplesAreRoundedToTheNearestUnit) {
  Random random(4);
  for (const float brightest : {0.0f, 1e-3f, 1.0f, 20000.0f, 1e6f, 1e12f}) {
    Film film(1, 1, brightest);
    RenderStats stats;
    long double exact = 0;
    std::vector<Sample> samples(1000);
    for (Sample& sample : samples) {
      const float value = float(std::max(brightest, 1e-3f) * random.Between(0, 1));
      sample = {0, {value, value, value}};
      exact += value;
    }
    Add(samples, 0, samples.size(), 100, film, stats);
    const long double sum = film.sums()[0] * static_cast<long double>(film.unit());
    // The error is half a unit per sample. The unit is 2^-52 of 64 to 128 times the brightest
    // radiance, but not below 2^-32.
    EXPECT_LE(std::fabs(double(sum - exact)), 0.5 * film.unit() * double(samples.size()));
    EXPECT_LE(film.unit(), std::max(128.0 * brightest * 0x1p-52, 0x1p-32)) << brightest;
    EXPECT_GE(film.unit() * 0x1p52, 64.0 * brightest) << brightest;
    EXPECT_EQ(std::exp2(std::round(std::log2(film.unit()))), film.unit());
    EXPECT_EQ(stats.clamped_samples, 0u);

    // At a radiance of a few units, rounding errors cancel, whereas truncation would accumulate.
    const double before = double(film.sums()[0]);
    exact = 0;
    for (Sample& sample : samples) {
      sample.rgb[0] = float(film.unit() * random.Between(0, 100));
      exact += sample.rgb[0] / film.unit();
    }
    Add(samples, 0, samples.size(), 100, film, stats);
    EXPECT_NEAR(double(film.sums()[0]) - before, double(exact), 0.05 * double(samples.size()));
  }
}

TEST(Film, AHundredThousandSamplesDoNotDrift) {
  // In float arithmetic, sums of 0.1 would be off by a percent at this length.
  Film film(1, 1, 16000);
  RenderStats stats;
  const std::vector<Sample> samples(100000, Sample{0, {0.1f, 1 / 3.0f, 12345.678f}});
  Add(samples, 0, samples.size(), kFullWave, film, stats);
  const Image image = film.Resolve(samples.size());
  EXPECT_EQ(image.rgb[0], 0.1f);
  EXPECT_EQ(image.rgb[1], 1 / 3.0f);
  EXPECT_EQ(image.rgb[2], 12345.678f);
}

TEST(Film, BrighterSamplesAreClampedAndCountedOnce) {
  Film film(2, 1, 1);
  const float limit = float(film.unit() * 0x1p52);
  RenderStats stats;
  Add({{1, {limit, 1, 0}}}, 0, 1, 4, film, stats);
  EXPECT_EQ(stats.clamped_samples, 0u);
  Add({{1, {2 * limit, kInfinity, 3e38f}}, {0, {1, 1, std::nextafter(limit, kInfinity)}}}, 0, 2, 4,
      film, stats);
  EXPECT_EQ(stats.clamped_samples, 2u);
  EXPECT_EQ(stats.invalid_samples, 0u);
  const std::uint64_t sample = std::uint64_t{1} << 52, one = std::uint64_t(1 / film.unit());
  EXPECT_EQ(Sums(film),
            (std::vector<std::uint64_t>{one, one, sample, 2 * sample, sample + one, sample}));
}

TEST(Film, NanAndNegativeChannelsCountAsZero) {
  Film film(1, 1, 1);
  RenderStats stats;
  Add({{0, {kNan, 1, 1}},
       {0, {1, -1, 1}},
       {0, {1, 1, -kInfinity}},
       {0, {-0.0f, 0, 0}},
       {0, {kNan, -1, kNan}}},
      0, 5, 8, film, stats);
  EXPECT_EQ(stats.invalid_samples, 4u);
  EXPECT_EQ(stats.clamped_samples, 0u);
  const std::uint64_t one = std::uint64_t(1 / film.unit());
  EXPECT_EQ(Sums(film), (std::vector<std::uint64_t>{2 * one, 2 * one, 2 * one}));
}

TEST(Film, SumsSaturateInsteadOfWrapping) {
  Film film(1, 1, 1), other(1, 1, 1);
  const float limit = float(film.unit() * 0x1p52);
  RenderStats stats;
  // 2^12 samples of 2^52 units exceed a sum by one unit.
  const std::vector<Sample> samples(4096, Sample{0, {limit, 0.5f * limit, 1}});
  Add(samples, 0, 4095, kFullWave, film, stats);
  EXPECT_EQ(film.sums()[0], std::uint64_t{4095} << 52);
  Add(samples, 0, 1, kFullWave, film, stats);
  EXPECT_EQ(film.sums()[0], kFull);
  EXPECT_EQ(film.sums()[1], std::uint64_t{1} << 63);
  Add(samples, 0, 4096, kFullWave, film, stats);
  EXPECT_EQ(film.sums()[0], kFull);
  EXPECT_EQ(film.sums()[1], kFull);
  EXPECT_EQ(film.sums()[2], 8192 * std::uint64_t(1 / film.unit()));

  Add(samples, 0, 3000, kFullWave, other, stats);
  Film twice = other;
  twice.Merge(other);
  EXPECT_EQ(twice.sums()[0], kFull);
  twice.Merge(film);
  EXPECT_EQ(twice.sums()[0], kFull);
}

TEST(Film, HoldsTheBrightestFloats) {
  Film film(1, 1, 3e38f);
  RenderStats stats;
  Add(std::vector<Sample>(1000, Sample{0, {3e38f, 1e33f, 1}}), 0, 1000, 64, film, stats);
  const Image image = film.Resolve(1000);
  EXPECT_FLOAT_EQ(image.rgb[0], 3e38f);
  EXPECT_FLOAT_EQ(image.rgb[1], 1e33f);
  EXPECT_EQ(stats.clamped_samples + stats.invalid_samples, 0u);
}

TEST(Film, AFilmWithoutSamplesIsBlack) {
  const Film film(3, 2, 5);
  const Image image = film.Resolve(0);
  EXPECT_EQ(image.width, 3);
  EXPECT_EQ(image.height, 2);
  EXPECT_EQ(image.rgb, std::vector<float>(18, 0.0f));
}

struct Splats {
  explicit Splats(std::uint32_t n) : lights(n), cameras(n) {}
  soa::Table<LightColumns> lights;
  soa::Table<CameraColumns> cameras;  // pixels only
};

// Returns the same samples as splats. Every third belongs to a ray that did not arrive, with values
// that must not be used.
Splats SplatsOf(const std::vector<Sample>& samples) {
  Splats splats{std::uint32_t(samples.size())};
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const bool arrives = i % 3 != 0;
    splats.cameras->pixel[i] = arrives ? samples[i].pixel : 0xFFFFFFFFu;
    splats.lights->t_far[i] = arrives ? float(i % 2) : -1;
    splats.lights->r[i] = samples[i].rgb[0];
    splats.lights->g[i] = samples[i].rgb[1];
    splats.lights->b[i] = arrives ? samples[i].rgb[2] : kNan;
  }
  return splats;
}

TEST(FilmSplats, SumsDoNotDependOnOrderOrThread) {
  constexpr std::uint32_t kPixels = 24;
  const std::vector<Sample> samples = WildSamples(6000, kPixels);
  const Splats splats = SplatsOf(samples);
  Film expected(6, 4, 16);
  RenderStats expected_stats;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i % 3 == 0) continue;
    Sample half = samples[i];
    for (float& value : half.rgb) value *= 0.5f;
    Add({half}, 0, 1, 1, expected, expected_stats);
  }
  ForEachTarget([&] {
    for (const std::uint32_t wave : {1u, 17u, 2048u}) {
      Film film(6, 4, 16, 0, 0, /*shared=*/true);
      constexpr std::uint32_t kThreads = 4;
      std::vector<RenderStats> stats(kThreads);
      std::vector<std::thread> threads;
      std::atomic<std::uint32_t> next = 0;
      for (std::uint32_t t = 0; t < kThreads; ++t) {
        threads.emplace_back([&, t] {
          for (std::uint32_t i = next.fetch_add(wave); i < 6000; i = next.fetch_add(wave)) {
            film.AddSplats(Slice(splats.lights.columns(), i), splats.cameras->pixel + i,
                           std::min(wave, 6000 - i), 0.5f, stats[t]);
          }
        });
      }
      for (std::thread& thread : threads) thread.join();
      EXPECT_EQ(Sums(film), Sums(expected)) << "wave " << wave;
      RenderStats sum;
      for (const RenderStats& s : stats) sum += s;
      EXPECT_EQ(sum.clamped_samples, expected_stats.clamped_samples);
      EXPECT_EQ(sum.invalid_samples, expected_stats.invalid_samples);
      EXPECT_EQ(sum.samples, 0u);
    }
  });
}

// A shared film also accepts samples from several threads, and saturates.
TEST(FilmSplats, MixWithSamplesAndSaturate) {
  const std::vector<Sample> samples = WildSamples(4000, 6);
  Film alone(3, 2, 16), shared(3, 2, 16, 0, 0, true);
  RenderStats stats, other;
  Add(samples, 0, samples.size(), 128, alone, stats);
  Add(samples, 0, samples.size(), 128, alone, stats);
  std::thread half([&] { Add(samples, 0, samples.size(), 64, shared, other); });
  Add(samples, 0, samples.size(), 17, shared, stats);
  half.join();
  EXPECT_EQ(Sums(shared), Sums(alone));

  const Sample bright = {1, {1e30f, 1e30f, 0}};
  const Splats splat = SplatsOf({bright, bright});
  for (int i = 0; i < 5000; ++i) shared.AddSplats(splat.lights, splat.cameras->pixel, 2, 1, stats);
  EXPECT_EQ(shared.sums()[3], kFull);
  Film merged(3, 2, 16);
  merged.Merge(shared);
  EXPECT_EQ(Sums(merged), Sums(shared));
}

}  // namespace
}  // namespace skywave
