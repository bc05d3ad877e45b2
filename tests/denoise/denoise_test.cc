// Pictures whose truth and noise are known: the denoiser has to come nearer to the truth, keep what
// features and statistics distinguish, keep energy, and estimate its error.
#include "job/denoise/denoise.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/denoise/planes.h"
#include "tests/support/noisy_picture.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

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
      EXPECT_EQ(NotesOf(clean).size(), 1u);
      EXPECT_TRUE(NotesOf(before).empty());
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
    EXPECT_LT(SquaredError(Clean(noisy).image, Flat), SquaredError(noisy.image, Flat) / 25);
  }
}

// Light of two sheets, one before the other, that differs by less than the noise of a half stays
// apart.
TEST(Denoise, StepsOfDepthAreEdges) {
  const Truth sheets = [](int x, int) { return Pixel{.light = x % 16 < 8 ? 1.0 : 1.15}; };
  Noisy noisy = Draw(sheets, 13);
  double light[2] = {0, 0};
  for (const bool is_stepped : {false, true}) {
    for (int i = 0; i < kSide * kSide; ++i) {
      noisy.at("depth.Z")[std::size_t(i)] = is_stepped && i % 16 >= 8 ? 5.0f : 4.0f;
    }
    const Denoised clean = Clean(noisy);
    double sums[2] = {0, 0};
    for (int i = 0; i < kSide * kSide; ++i) {
      sums[i % 16 >= 8] += clean.image.rgb[3 * std::size_t(i)] / (kSide * kSide / 2);
    }
    light[is_stepped] = sums[1] - sums[0];
  }
  EXPECT_NEAR(light[true], 0.15, 0.02);
  EXPECT_LT(light[false], 0.1);
}

// Pixels that a slanted edge divides show a share of each surface, and the same share of their
// normals: neighbours on both sides say what they are, though no other pixel is like them.
TEST(Denoise, EdgesLoseTheirNoise) {
  const auto share = [](int x, int y) { return std::clamp(x - 30.2 - 0.31 * y, 0.0, 1.0); };
  const Truth edge = [&](int x, int y) { return Pixel{.light = 1 + 2 * share(x, y)}; };
  Noisy noisy = Draw(edge, 23);
  const auto is_edge = [&](int x, int y) { return share(x, y) > 0 && share(x, y) < 1; };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const std::size_t i = std::size_t(y * kSide + x);
      noisy.at("shading-normal.X")[i] = float(share(x, y));
      noisy.at("shading-normal.Z")[i] = float(1 - share(x, y));
    }
  }
  const auto error = [&](const Image& image) {
    double sum = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        if (!is_edge(x, y)) continue;
        const double apart = image.rgb[3 * std::size_t(y * kSide + x)] - edge(x, y).light;
        sum += apart * apart;
      }
    }
    return sum;
  };
  const Denoised clean = Clean(noisy);
  EXPECT_LT(error(clean.image), error(noisy.image) / 5);
  const double coverage = Coverage(clean, edge);
  EXPECT_GT(coverage, 0.93);
}

// A pixel whose samples are all alike by accident is no better known than those around it.
TEST(Denoise, PixelsWithoutVarianceAreAveraged) {
  for (const double light : {0.5, 0.0}) {
    const Truth dots = [&](int x, int y) {
      return x % 8 == 4 && y % 8 == 4 ? Pixel{.light = light, .deviation = 0}
                                      : Pixel{.light = 1, .deviation = 2};
    };
    const Denoised clean = Clean(Draw(dots, 22));
    double mean = 0;
    for (int y = 4; y < kSide; y += 8) {
      for (int x = 4; x < kSide; x += 8) {
        mean += clean.image.rgb[3 * std::size_t(y * kSide + x)] / (kSide / 8 * kSide / 8);
      }
    }
    EXPECT_NEAR(mean, 1, 0.15) << light;
  }
}

}  // namespace
}  // namespace skywave
