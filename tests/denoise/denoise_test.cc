// Pictures whose truth and noise are known: the denoiser has to come nearer to the truth, keep what
// features and statistics tell apart, keep energy, and know its error.
#include "job/denoise/denoise.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "job/denoise/planes.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr int kSide = 96;
constexpr int kSamples = 16;

// What a pixel shows.
struct Pixel {
  double light = 1, deviation = 0.5;  // mean and standard deviation of a sample
  double albedo = 1, coverage = 1;
};
using Truth = std::function<Pixel(int x, int y)>;

// A picture with its layers, as the film resolves them.
struct Noisy {
  Image image;
  std::vector<NamedChannel> layers;

  std::vector<float>& at(const std::string& name) {
    for (NamedChannel& layer : layers) {
      if (layer.name == name) return layer.values;
    }
    throw std::out_of_range(name);
  }
};

double TrueValue(const Pixel& pixel) { return pixel.light * pixel.albedo; }

// Draws the samples of every pixel, the same for all channels, from a normal distribution. One in
// `period` of them is in the second half.
Noisy Draw(const Truth& truth, std::uint32_t seed, int width = kSide, int height = kSide,
           int period = 2) {
  Noisy noisy{.image = Image(width, height), .layers = {}};
  for (const std::string& name : DenoiserChannels()) {
    noisy.layers.push_back({name, std::vector<float>(std::size_t(width) * height, 0)});
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // The samples of a pixel are its own, however large the picture is.
      std::mt19937_64 random(seed * 1000003ull + std::uint64_t(y) * 8192 + std::uint64_t(x));
      std::normal_distribution<double> normal;
      const Pixel pixel = truth(x, y);
      double sums[2] = {0, 0}, squares[2] = {0, 0};
      int second = 0;
      for (int i = 0; i < kSamples; ++i) {
        const double value = TrueValue(pixel) + pixel.deviation * pixel.albedo * normal(random);
        const bool is_second = i % period == period - 1;
        second += is_second;
        sums[is_second] += value, squares[is_second] += value * value;
      }
      const auto variance = [](double n, double sum, double square) {
        return (square - sum * sum / n) / (n - 1);
      };
      const std::size_t i = std::size_t(y) * width + x;
      const double all = sums[0] + sums[1];
      noisy.at("samples.V")[i] = kSamples;
      noisy.at("half.N")[i] = float(second);
      noisy.at("coverage.V")[i] = float(pixel.coverage);
      noisy.at("depth.Z")[i] = 4;
      noisy.at("shading-normal.Z")[i] = 1;
      for (int c = 0; c < 3; ++c) {
        const std::string letter(1, "RGB"[c]);
        noisy.image.rgb[3 * i + std::size_t(c)] = float(all / kSamples);
        noisy.at("half." + letter)[i] = float(sums[1] / second);
        noisy.at("variance." + letter)[i] = float(variance(kSamples, all, squares[0] + squares[1]));
        noisy.at("half-variance." + letter)[i] = float(variance(second, sums[1], squares[1]));
        noisy.at("albedo." + letter)[i] = float(pixel.albedo);
      }
    }
  }
  return noisy;
}

Denoised Clean(const Noisy& noisy) { return Denoise("noisy.exr", noisy.image, noisy.layers); }

double SquaredError(const Image& image, const Truth& truth) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double error =
          image.rgb[3 * (std::size_t(y) * image.width + x)] - TrueValue(truth(x, y));
      sum += error * error;
    }
  }
  return sum / image.width / image.height;
}

// Returns the share of pixels whose truth is within 1.96 times the estimated error.
double Coverage(const Denoised& clean, const Truth& truth) {
  int inside = 0;
  const int width = clean.image.width;
  for (int y = 0; y < clean.image.height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t i = std::size_t(y) * width + x;
      const double error = std::abs(clean.image.rgb[3 * i] - TrueValue(truth(x, y)));
      inside += error <= 1.96 * clean.error[0].values[i];
    }
  }
  return double(inside) / width / clean.image.height;
}

double Sum(const Image& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += value;
  return sum;
}

std::vector<std::uint32_t> Bits(const Denoised& clean) {
  std::vector<std::uint32_t> bits;
  for (const float value : clean.image.rgb) bits.push_back(std::bit_cast<std::uint32_t>(value));
  for (const NamedChannel& channel : clean.error) {
    for (const float value : channel.values) bits.push_back(std::bit_cast<std::uint32_t>(value));
  }
  return bits;
}

Pixel Flat(int, int) { return {}; }
Pixel Steps(int x, int) { return {.light = x < kSide / 2 ? 1.0 : 3.0}; }
Pixel Checkered(int x, int y) { return {.albedo = (x / 2 + y / 2) % 2 == 0 ? 0.2 : 0.8}; }
Pixel Slope(int x, int y) { return {.light = 1 + 0.01 * x + 0.005 * y}; }

TEST(Denoise, FlatLightLosesItsNoise) {
  const Noisy noisy = Draw(Flat, 1);
  const Denoised clean = Clean(noisy);
  EXPECT_LT(SquaredError(clean.image, Flat), SquaredError(noisy.image, Flat) / 25);
  EXPECT_EQ(clean.outliers, 0u);
}

// The mean of pictures with many seeds is the truth, to within four standard errors.
TEST(Denoise, FlatLightKeepsItsMean) {
  double sum = 0, square = 0;
  constexpr int kRuns = 20;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) {
    const double mean = Sum(Clean(Draw(Flat, 100 + seed)).image) / (3.0 * kSide * kSide);
    sum += mean, square += mean * mean;
  }
  const double mean = sum / kRuns;
  const double error = std::sqrt((square / kRuns - mean * mean) / (kRuns - 1));
  EXPECT_NEAR(mean, 1, 4 * error);
  EXPECT_LT(error, 1e-3);
}

TEST(Denoise, EdgesThatSamplesResolveStay) {
  const Noisy noisy = Draw(Steps, 2);
  const Denoised clean = Clean(noisy);
  double left = 0, right = 0;
  for (int y = 8; y < kSide - 8; ++y) {
    left += clean.image.rgb[3 * std::size_t(y * kSide + kSide / 2 - 1)];
    right += clean.image.rgb[3 * std::size_t(y * kSide + kSide / 2)];
  }
  EXPECT_NEAR(left / (kSide - 16), 1, 0.03);
  EXPECT_NEAR(right / (kSide - 16), 3, 0.03);
  EXPECT_LT(SquaredError(clean.image, Steps), SquaredError(noisy.image, Steps) / 15);
}

TEST(Denoise, TexturesStay) {
  const Noisy noisy = Draw(Checkered, 3);
  const Denoised clean = Clean(noisy);
  EXPECT_LT(SquaredError(clean.image, Checkered), SquaredError(noisy.image, Checkered) / 8);
  double dark = 0, bright = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double value = clean.image.rgb[3 * std::size_t(y * kSide + x)];
      (Checkered(x, y).albedo < 0.5 ? dark : bright) += value;
    }
  }
  EXPECT_NEAR(dark / (kSide * kSide / 2), 0.2, 0.002);
  EXPECT_NEAR(bright / (kSide * kSide / 2), 0.8, 0.008);
}

// A thin line of another surface has other features; a pixel that nothing is like stays as it is.
TEST(Denoise, ThinThingsStay) {
  const Truth line = [](int x, int) { return Pixel{.light = x == 40 ? 1.2 : 1.0}; };
  Noisy noisy = Draw(line, 4);
  for (int y = 0; y < kSide; ++y) noisy.at("shading-normal.X")[std::size_t(y * kSide + 40)] = 1;
  const Denoised clean = Clean(noisy);
  double mean = 0, beside = 0;
  for (int y = 0; y < kSide; ++y) {
    mean += clean.image.rgb[3 * std::size_t(y * kSide + 40)] / kSide;
    beside += clean.image.rgb[3 * std::size_t(y * kSide + 41)] / kSide;
  }
  EXPECT_NEAR(mean, 1.2, 0.05);
  EXPECT_NEAR(beside, 1, 0.03);
}

// A highlight is noisier than what lies beside it by far. It says nothing about that.
TEST(Denoise, HighlightsDoNotLeak) {
  const Truth highlight = [](int x, int) {
    return x < kSide / 2 ? Pixel{.light = 0.14, .deviation = 0.08}
                         : Pixel{.light = 1000, .deviation = 1500};
  };
  const Denoised clean = Clean(Draw(highlight, 16));
  double most = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = kSide / 2 - 6; x < kSide / 2; ++x) {
      most = std::max(most, double(clean.image.rgb[3 * std::size_t(y * kSide + x)]));
    }
  }
  EXPECT_LT(most, 0.3);
}

// Single pixels that stand out by seven standard deviations of a half are no accident: no neighbour
// is averaged with them, though the pixels around are alike.
TEST(Denoise, DotsStay) {
  const Truth dots = [](int x, int y) {
    return Pixel{.light = x % 8 == 4 && y % 8 == 4 ? 2.2 : 1.0};
  };
  const Denoised clean = Clean(Draw(dots, 17));
  double mean = 0;
  for (int y = 4; y < kSide; y += 8) {
    for (int x = 4; x < kSide; x += 8) {
      mean += clean.image.rgb[3 * std::size_t(y * kSide + x)] / (kSide / 8 * kSide / 8);
    }
  }
  EXPECT_GT(mean, 2.1);
}

// Pixels that an object covers in part keep their value, though half of what they show is sky.
TEST(Denoise, PartialCoverageStays) {
  const Truth edge = [](int x, int) {
    const double coverage = std::clamp((kSide / 2 + 1 - x) / 2.0, 0.0, 1.0);
    return Pixel{.light = 1 + 0.2 * coverage, .deviation = 0.4, .coverage = coverage};
  };
  const Denoised clean = Clean(Draw(edge, 18));
  for (const int x : {kSide / 2 - 1, kSide / 2, kSide / 2 + 1}) {
    double mean = 0;
    for (int y = 0; y < kSide; ++y) {
      mean += clean.image.rgb[3 * std::size_t(y * kSide + x)] / kSide;
    }
    EXPECT_NEAR(mean, edge(x, 0).light, 0.03) << x;
  }
}

TEST(Denoise, WithoutNoiseNothingChanges) {
  const Truth still = [](int x, int y) {
    return Pixel{.light = 1 + x % 7 + 0.3 * (y % 5), .deviation = 0, .albedo = 0.5};
  };
  const Noisy noisy = Draw(still, 5);
  const Denoised clean = Clean(noisy);
  for (std::size_t i = 0; i < clean.image.rgb.size(); ++i) {
    ASSERT_NEAR(clean.image.rgb[i], noisy.image.rgb[i], 2e-6 * noisy.image.rgb[i]) << i;
  }
}

TEST(Denoise, IntervalsCoverTheStatedShareOfErrors) {
  for (const Truth& truth : {Truth(Flat), Truth(Slope), Truth(Steps), Truth(Checkered)}) {
    const Denoised clean = Clean(Draw(truth, 6));
    const double coverage = Coverage(clean, truth);
    EXPECT_GT(coverage, 0.93);
    EXPECT_LT(coverage, 0.985);
  }
}

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

// The channels of a picture are alike: one whose colours and axes are turned round becomes the
// turned picture.
TEST(Denoise, ChannelsAreTreatedAlike) {
  const Truth truths[] = {
      [](int x, int) { return Pixel{.light = x < kSide / 2 ? 1.0 : 1.6}; },
      [](int x, int y) { return Pixel{.light = 1 + 0.01 * x + 0.005 * y, .deviation = 0.2}; },
      [](int x, int y) {
        return Pixel{.deviation = 0.8, .albedo = (x / 2 + y / 2) % 2 == 0 ? 0.7 : 0.75};
      }};
  // Returns the picture whose channel c + turn is drawn from truth c, modulo 3.
  const auto drawn = [&](std::size_t turn) {
    Noisy noisy = Draw(Flat, 20);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t to = (c + turn) % 3;
      Noisy of_channel = Draw(truths[c], 30 + std::uint32_t(c));
      for (std::size_t i = to; i < noisy.image.rgb.size(); i += 3) {
        noisy.image.rgb[i] = of_channel.image.rgb[i];
      }
      for (const char* const name : {"half.", "variance.", "half-variance.", "albedo."}) {
        const std::string channel = name + std::string(1, "RGB"[to]);
        noisy.at(channel) = of_channel.at(channel);
      }
      // Blocks of 8 x 8, 4 x 4 and 2 x 2 pixels lean by half of what makes strangers of them.
      std::vector<float>& normal = noisy.at("shading-normal." + std::string(1, "XYZ"[to]));
      for (std::size_t i = 0; i < normal.size(); ++i) {
        const std::size_t block = 8 >> c;
        normal[i] = (i % kSide / block + i / kSide / block) % 2 == 0 ? 0.05f : 0.1f;
      }
    }
    return noisy;
  };
  const Denoised plain = Clean(drawn(0));
  for (const std::size_t turn : {1, 2}) {
    SCOPED_TRACE(turn);
    const Denoised turned = Clean(drawn(turn));
    for (std::size_t i = 0; i < plain.image.rgb.size(); ++i) {
      const std::size_t c = i % 3, to = (c + turn) % 3;
      ASSERT_NEAR(plain.image.rgb[i], turned.image.rgb[i - c + to], 1e-4) << i / 3 << ' ' << c;
      ASSERT_NEAR(plain.error[c].values[i / 3], turned.error[to].values[i / 3], 1e-4)
          << i / 3 << ' ' << c;
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

TEST(Denoise, OutliersAreSpreadAndEnergyIsKept) {
  for (const int half : {0, 1}) {
    for (const int period : {2, 3}) {
      SCOPED_TRACE(testing::Message() << half << ' ' << period);
      Noisy noisy = Draw(Flat, 7, kSide, kSide, period);
      const Denoised before = Clean(noisy);
      // One sample of a half was 4000 times as bright as the others.
      const std::size_t at = 48 * kSide + 50;
      const float second = noisy.at("half.N")[at];
      for (const char* const letter : {"R", "G", "B"}) {
        const std::string channel(letter);
        noisy.image.rgb[3 * at + std::size_t(std::string("RGB").find(channel))] +=
            4000.0f / kSamples;
        noisy.at("variance." + channel)[at] += 4000.0f * 4000 / kSamples;
        if (half == 0) continue;
        noisy.at("half." + channel)[at] += 4000.0f / second;
        noisy.at("half-variance." + channel)[at] += 4000.0f * 4000 / second;
      }
      const Denoised clean = Clean(noisy);
      EXPECT_EQ(clean.outliers, 1u);
      EXPECT_NE(OutlierNote(clean), "");
      EXPECT_EQ(OutlierNote(before), "");
      const double given = 3 * 4000.0 / kSamples;
      EXPECT_NEAR((Sum(clean.image) - Sum(before.image)) / given, 1, 0.01);
      EXPECT_NEAR(clean.spread_share, given / Sum(noisy.image), 0.01 * given / Sum(noisy.image));
      EXPECT_LT(clean.image.rgb[3 * at], 6);
      EXPECT_NEAR(clean.image.rgb[3 * (at + 30)], 1, 0.3);
    }
  }
}

// The excess goes to what reflects: not to the sky beside the surface.
TEST(Denoise, OutliersStayOnTheirSurface) {
  const Truth half_sky = [](int x, int) {
    return Pixel{.light = 1, .deviation = 0.1, .coverage = x < kSide / 2 ? 1.0 : 0.0};
  };
  Noisy noisy = Draw(half_sky, 8);
  const Denoised before = Clean(noisy);
  const std::size_t at = 48 * kSide + kSide / 2 - 4;
  for (const int c : {0, 1, 2}) {
    const std::string channel(1, "RGB"[c]);
    noisy.image.rgb[3 * at + std::size_t(c)] += 100;
    noisy.at("half." + channel)[at] += 200;
    noisy.at("variance." + channel)[at] += 16 * 10000;
    noisy.at("half-variance." + channel)[at] += 16 * 20000;
  }
  const Denoised clean = Clean(noisy);
  double surface = 0, sky = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const std::size_t i = 3 * std::size_t(y * kSide + x);
      (x < kSide / 2 ? surface : sky) += clean.image.rgb[i] - before.image.rgb[i];
    }
  }
  EXPECT_NEAR(surface, 100, 2);
  EXPECT_LT(sky, 1);
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
  constexpr int kRim = 12;
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

// A floor that recedes by 6 % of its distance a pixel is one surface, whose noise is averaged,
// along either axis of the picture.
TEST(Denoise, SlantedSurfacesAreAveraged) {
  const Noisy flat = Draw(Flat, 13);
  for (const bool along_x : {true, false}) {
    SCOPED_TRACE(along_x);
    Noisy noisy = flat;
    const auto set_depth = [&](const auto& depth) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          noisy.at("depth.Z")[std::size_t(y * kSide + x)] = depth(along_x ? x : y);
        }
      }
    };
    set_depth([](int i) { return 4 * std::exp(0.06f * float(i)); });
    const double slanted = SquaredError(Clean(noisy).image, Flat);
    EXPECT_LT(slanted, SquaredError(noisy.image, Flat) / 25);
    // Steps are edges, on both sides of which there is less to average.
    set_depth([](int i) { return i % 4 < 2 ? 4.0f : 5.0f; });
    EXPECT_GT(SquaredError(Clean(noisy).image, Flat), 1.4 * slanted);
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
  few.at("samples.V")[10] = 4, few.at("half.N")[10] = 2;
  ExpectError(few, "pixel (2, 1) has 4 samples");

  Noisy one_half = Draw(Flat, 12, 8, 8);
  one_half.at("half.N")[0] = 0;
  ExpectError(one_half, "0 of them in one half");
}

// A pixel whose samples are all alike by accident is no better known than those around it.
TEST(Denoise, PixelsWithoutVarianceAreAveraged) {
  const Truth dots = [](int x, int y) {
    return x % 8 == 4 && y % 8 == 4 ? Pixel{.light = 0.5, .deviation = 0}
                                    : Pixel{.light = 1, .deviation = 2};
  };
  const Denoised clean = Clean(Draw(dots, 22));
  double mean = 0;
  for (int y = 4; y < kSide; y += 8) {
    for (int x = 4; x < kSide; x += 8) {
      mean += clean.image.rgb[3 * std::size_t(y * kSide + x)] / (kSide / 8 * kSide / 8);
    }
  }
  EXPECT_NEAR(mean, 1, 0.15);
}

}  // namespace
}  // namespace skywave
