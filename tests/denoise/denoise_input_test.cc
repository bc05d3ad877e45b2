// The input of the denoiser: planes of both halves, bad and extreme input, and what bytes depend
// on.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "job/denoise/denoise.h"
#include "job/denoise/planes.h"
#include "tests/support/noisy_picture.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

// What is known of each half is that of its samples alone, channel by channel, though files keep
// the second half and the whole.
TEST(Planes, HoldTheMeansAndTheNoiseOfBothHalves) {
  constexpr int kWidth = 5, kHeight = 3, kFirst = 11, kSecond = 5;
  Noisy noisy{.image = Image(kWidth, kHeight), .layers = {}};
  for (const std::string& name : DenoiserChannels()) {
    noisy.layers.push_back({name, std::vector<float>(std::size_t(kWidth) * kHeight, 0)});
  }
  struct Half {
    double mean[3] = {}, noise = 0;  // of light, over its count
  };
  std::vector<std::array<Half, 2>> expected;
  std::mt19937_64 random(21);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.1, 1);
  for (std::size_t i = 0; i < std::size_t(kWidth) * kHeight; ++i) {
    std::array<Half, 2>& halves = expected.emplace_back();
    noisy.at("samples.V")[i] = kFirst + kSecond, noisy.at("half.N")[i] = kSecond;
    noisy.at("coverage.V")[i] = 1, noisy.at("depth.Z")[i] = float(std::exp(uniform(random)));
    for (const int c : {0, 1, 2}) {
      const std::string letter(1, "RGB"[c]);
      const double albedo = uniform(random), level = 3 * uniform(random);
      std::vector<double> samples;
      for (int k = 0; k < kFirst + kSecond; ++k) samples.push_back(level + 0.3 * normal(random));
      const auto moments = [&](int first, int end) {
        double sum = 0, squares = 0;
        for (int k = first; k < end; ++k) sum += samples[std::size_t(k)];
        const double mean = sum / (end - first);
        for (int k = first; k < end; ++k) squares += std::pow(samples[std::size_t(k)] - mean, 2);
        return std::pair(mean, squares / (end - first - 1));
      };
      const auto [all, variance] = moments(0, kFirst + kSecond);
      const auto [second, half_variance] = moments(kFirst, kFirst + kSecond);
      const auto [first, first_variance] = moments(0, kFirst);
      noisy.image.rgb[3 * i + std::size_t(c)] = float(all);
      noisy.at("variance." + letter)[i] = float(variance);
      noisy.at("half." + letter)[i] = float(second);
      noisy.at("half-variance." + letter)[i] = float(half_variance);
      noisy.at("albedo." + letter)[i] = float(albedo);
      noisy.at("shading-normal." + std::string(1, "XYZ"[c]))[i] = float(uniform(random));
      halves[0].mean[c] = first, halves[1].mean[c] = second;
      // In units of what the albedo reflects.
      const double light2 = std::pow(albedo + 0.02, 2);
      halves[0].noise += first_variance / kFirst / light2;
      halves[1].noise += half_variance / kSecond / light2;
    }
  }
  const DenoiserInput input = FindInput("noisy.exr", noisy.image, noisy.layers);
  const PlaneShape shape = {kWidth, kHeight};
  DenoiserPlanes planes(shape);
  for (int y = 0; y < kHeight; ++y) ReadRow(input, y, planes);
  const double unit2 = double(input.brightness) * input.brightness;
  const FeaturePlanes& features = planes.features;
  const std::pair<const char*, const float*> alike[] = {
      {"shading-normal.X", features.normal_x}, {"shading-normal.Y", features.normal_y},
      {"shading-normal.Z", features.normal_z}, {"albedo.R", features.albedo_r},
      {"albedo.G", features.albedo_g},         {"albedo.B", features.albedo_b}};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      SCOPED_TRACE(testing::Message() << x << ' ' << y);
      const std::size_t at = shape.at(x, y), i = std::size_t(y * kWidth + x);
      const float texture[] = {planes.texture->r[at], planes.texture->g[at], planes.texture->b[at]};
      for (int h = 0; h < 2; ++h) {
        const HalfPlanes half = planes.halves[h];
        const float light[] = {half.r[at], half.g[at], half.b[at]};
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(light[c] * texture[c], expected[i][std::size_t(h)].mean[c], 1e-5) << h << c;
        }
        EXPECT_NEAR(half.noise[at] * unit2 / expected[i][std::size_t(h)].noise, 1, 1e-3) << h;
      }
      // The features are those of the picture in units of 0.1, and so is the depth's logarithm in
      // units of 0.02.
      for (const auto& [name, plane] : alike) {
        EXPECT_NEAR(plane[at], 10 * noisy.at(name)[i], 1e-4) << name;
      }
      EXPECT_NEAR(features.depth[at], 50 * std::log(noisy.at("depth.Z")[i]), 1e-3);
    }
  }
}

// Halves of unequal counts are both in the picture by their samples, here five and eleven.
TEST(Denoise, UnequalHalvesKeepTheMean) {
  const Noisy noisy = Draw(Flat, 19, kSide, kSide, 3);
  ASSERT_EQ(noisy.layers.size(), DenoiserChannels().size());
  const Denoised clean = Clean(noisy);
  EXPECT_LT(SquaredError(clean.image, Flat), SquaredError(noisy.image, Flat) / 25);
  // A single pixel has nothing to be averaged with.
  const Noisy alone = Draw(Flat, 19, 1, 1, 3);
  const Denoised same = Clean(alone);
  for (const std::size_t c : {0, 1, 2}) {
    EXPECT_NEAR(same.image.rgb[c], alone.image.rgb[c], 1e-5);
  }
}

TEST(Denoise, BytesDoNotDependOnThreads) {
  const Noisy noisy = Draw(Steps, 9, 150, 70);
  std::vector<std::uint32_t> bits;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const std::vector<std::uint32_t> these = Bits(Clean(noisy));
    if (bits.empty()) bits = these;
    EXPECT_EQ(these, bits) << threads;
  }
}

TEST(Denoise, BytesDoNotDependOnTheInstructionSet) {
  const Noisy noisy = Draw(Slope, 10, 77, 41);
  ExpectSameOnEveryTarget([&] { return Bits(Clean(noisy)); });
}

// A part with a rim has the pixels of the whole.
TEST(Denoise, APixelDependsOnItsSurroundings) {
  constexpr int kRim = 28;
  const Truth whole = [](int x, int y) { return Pixel{.light = 1 + (x > 50) + 0.5 * (y > 40)}; };
  const Truth part = [&](int x, int y) { return whole(x, y); };
  const Denoised large = Clean(Draw(whole, 11, 120, 100)), small = Clean(Draw(part, 11, 80, 70));
  for (int y = 0; y < 70 - kRim; ++y) {
    for (int x = 0; x < 80 - kRim; ++x) {
      ASSERT_EQ(small.image.rgb[3 * std::size_t(y * 80 + x)],
                large.image.rgb[3 * std::size_t(y * 120 + x)])
          << x << ' ' << y;
    }
  }
}

TEST(Denoise, SmallPicturesAndNegativeValuesAreDenoised) {
  const Truth below_zero = [](int x, int) { return Pixel{.light = x % 2 == 0 ? -1.0 : 0.5}; };
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {1, 40}, {65, 9}}) {
    const Noisy noisy = Draw(below_zero, 14, width, height);
    const Denoised clean = Clean(noisy);
    double most = 0;
    for (const float value : noisy.image.rgb) most = std::max(most, double(std::abs(value)));
    for (const float value : clean.image.rgb) {
      EXPECT_LE(std::abs(value), 2 * most) << width << ' ' << height;
    }
    for (const NamedChannel& channel : clean.error) {
      for (const float value : channel.values) EXPECT_TRUE(value >= 0 && std::isfinite(value));
    }
  }
}

// Radiance has no scale of its own.
TEST(Denoise, DarkPicturesAreDenoisedAlike) {
  const Truth dark = [](int x, int y) {
    Pixel pixel = Steps(x, y);
    pixel.light *= 1e-7, pixel.deviation *= 1e-7;
    return pixel;
  };
  const Noisy noisy = Draw(Steps, 15), faint = Draw(dark, 15);
  const double gain = SquaredError(noisy.image, Steps) / SquaredError(Clean(noisy).image, Steps);
  EXPECT_NEAR(SquaredError(faint.image, dark) / SquaredError(Clean(faint).image, dark) / gain, 1,
              0.01);
}

void ExpectError(const Noisy& noisy, const std::string& words) {
  try {
    Clean(noisy);
    ADD_FAILURE() << "not refused: " << words;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("noisy.exr"), std::string::npos);
  }
}

TEST(Denoise, BadInputIsRefused) {
  Noisy without = Draw(Flat, 12, 8, 8);
  std::erase_if(without.layers, [](const NamedChannel& layer) { return layer.name == "half.G"; });
  ExpectError(without, "half.G");

  Noisy other_size = Draw(Flat, 12, 8, 8);
  other_size.at("albedo.R").resize(63);
  ExpectError(other_size, "has 64 pixels, and its channel albedo.R 63");

  Noisy not_a_number = Draw(Flat, 12, 8, 8);
  not_a_number.at("variance.B")[19] = std::numeric_limits<float>::quiet_NaN();
  ExpectError(not_a_number, "channel variance.B is nan in pixel (3, 2)");

  Noisy infinite = Draw(Flat, 12, 8, 8);
  infinite.image.rgb[5] = std::numeric_limits<float>::infinity();
  ExpectError(infinite, "is inf in pixel (1, 0)");

  Noisy few = Draw(Flat, 12, 8, 8);
  few.at("samples.V")[10] = 3, few.at("half.N")[10] = 1;
  ExpectError(few, "pixel (2, 1) has 3 samples");

  Noisy one_half = Draw(Flat, 12, 8, 8);
  one_half.at("half.N")[0] = 0;
  ExpectError(one_half, "0 of them in one half");
}

}  // namespace
}  // namespace skywave
