// Tests that the light of groups is cleaned as the picture is: the groups add up to the clean
// picture, each is nearer to its own light, and what the picture shows of edges and outliers holds
// for them too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/denoise/denoise.h"
#include "tests/support/noisy_picture.h"

namespace skywave {
namespace {

using Share = std::function<double(int x, int y)>;  // of the light of the first group

// Adds the layers of two groups, whose shares of each pixel have noise of their own.
void AddGroups(Noisy& noisy, const Share& share, std::uint32_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 0.1);
  const std::size_t pixels = noisy.image.rgb.size() / 3;
  std::vector<double> shares(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    shares[i] = share(int(i % kSide), int(i / kSide)) + normal(random);
  }
  for (const bool first : {true, false}) {
    for (std::size_t c = 0; c < 3; ++c) {
      NamedChannel channel = {std::string(first ? "lights-key." : "lights-fill.") + "RGB"[c],
                              std::vector<float>(pixels)};
      for (std::size_t i = 0; i < pixels; ++i) {
        const double part = first ? shares[i] : 1 - shares[i];
        channel.values[i] = float(part * double(noisy.image.rgb[3 * i + c]));
      }
      noisy.layers.push_back(std::move(channel));
    }
  }
}

// Returns the mean square of what a channel differs by from the light of the first group.
double SquaredError(const std::vector<float>& values, const Truth& truth, const Share& share) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int x = int(i % kSide), y = int(i / kSide);
    sum += std::pow(double(values[i]) - share(x, y) * TrueValue(truth(x, y)), 2);
  }
  return sum / double(values.size());
}

double Third(int, int) { return 1.0 / 3; }

TEST(CleanGroups, AddUpToTheCleanPicture) {
  for (const Truth& truth : {Truth(Flat), Truth(Steps), Truth(Checkered)}) {
    Noisy noisy = Draw(truth, 1);
    AddGroups(noisy, Third, 2);
    const Denoised clean = Clean(noisy);
    ASSERT_EQ(clean.groups.size(), 6u);
    EXPECT_EQ(clean.groups[1].name, "lights-key.G");
    for (std::size_t i = 0; i < clean.image.rgb.size(); ++i) {
      const float sum = clean.groups[i % 3].values[i / 3] + clean.groups[3 + i % 3].values[i / 3];
      ASSERT_NEAR(sum, clean.image.rgb[i], 1e-5) << i;
    }
  }
}

TEST(CleanGroups, AreNearerToTheirLight) {
  Noisy noisy = Draw(Flat, 1);
  AddGroups(noisy, Third, 2);
  const Denoised clean = Clean(noisy);
  EXPECT_LT(SquaredError(clean.groups[0].values, Flat, Third),
            SquaredError(noisy.at("lights-key.R"), Flat, Third) / 20);
}

// Light of other pixels does not come over an edge that the whole picture shows.
TEST(CleanGroups, KeepTheEdgesOfThePicture) {
  const Share share = [](int x, int) { return x < kSide / 2 ? 0.2 : 0.7; };
  Noisy noisy = Draw(Steps, 3);
  AddGroups(noisy, share, 4);
  const Denoised clean = Clean(noisy);
  double left = 0, right = 0;
  for (int y = 8; y < kSide - 8; ++y) {
    left += clean.groups[0].values[std::size_t(y * kSide + kSide / 2 - 1)] / (kSide - 16);
    right += clean.groups[0].values[std::size_t(y * kSide + kSide / 2)] / (kSide - 16);
  }
  // As far as the picture itself does; see Denoise.EdgesThatSamplesResolveStay.
  EXPECT_NEAR(left, 0.2 * 1, 0.03);
  EXPECT_NEAR(right, 0.7 * 3, 0.05);
}

// One sample of the second half, all of it light of the first group, is 40000 times as bright.
TEST(CleanGroups, AreNotThoseOfAnOutlierAround) {
  constexpr float kOutlier = 40000;
  Noisy noisy = Draw(Flat, 7);
  AddGroups(noisy, Third, 8);
  const std::size_t at = 48 * kSide + 50;
  const float second = noisy.at("half.N")[at];
  for (const char* const letter : {"R", "G", "B"}) {
    const std::string channel(letter);
    const float more = kOutlier / kSamples;
    noisy.image.rgb[3 * at + std::string("RGB").find(channel)] += more;
    noisy.at("lights-key." + channel)[at] += more;
    noisy.at("variance." + channel)[at] += kOutlier * kOutlier / kSamples;
    noisy.at("half." + channel)[at] += kOutlier / second;
    noisy.at("half-variance." + channel)[at] += kOutlier * kOutlier / second;
  }
  const Denoised clean = Clean(noisy);
  ASSERT_EQ(clean.outliers, 1u);
  for (const std::size_t beside : {at - 1, at + 2, at + 5 * kSide, at - 12}) {
    EXPECT_NEAR(clean.groups[0].values[beside] / clean.image.rgb[3 * beside], 1.0 / 3, 0.05);
  }
}

// Where nothing has found light, what others spread there is of both.
TEST(CleanGroups, DivideTheDark) {
  Noisy noisy = Draw([](int, int) { return Pixel{.light = 0, .deviation = 0}; }, 1);
  AddGroups(noisy, Third, 2);
  for (const NamedChannel& channel : Clean(noisy).groups) {
    for (const float value : channel.values) ASSERT_EQ(value, 0) << channel.name;
  }
}

// Files have channels in the order of their names.
TEST(CleanGroups, DoNotDependOnTheOrderOfChannels) {
  Noisy noisy = Draw(Flat, 1);
  AddGroups(noisy, Third, 2);
  for (float& value : noisy.at("lights-fill.B")) value *= 0.5f;
  const Denoised clean = Clean(noisy);
  std::reverse(noisy.layers.begin(), noisy.layers.end());
  const Denoised reversed = Clean(noisy);
  ASSERT_EQ(reversed.groups.size(), 6u);
  for (const NamedChannel& channel : clean.groups) {
    const auto same = std::find_if(reversed.groups.begin(), reversed.groups.end(),
                                   [&](const NamedChannel& c) { return c.name == channel.name; });
    ASSERT_NE(same, reversed.groups.end()) << channel.name;
    EXPECT_EQ(same->values, channel.values) << channel.name;
  }
}

TEST(CleanGroups, WithoutAColourAreRefused) {
  Noisy noisy = Draw(Flat, 1);
  AddGroups(noisy, Third, 2);
  std::erase_if(noisy.layers, [](const NamedChannel& c) { return c.name == "lights-key.G"; });
  EXPECT_THROW(Clean(noisy), InputError);
}

TEST(CleanGroups, AreOfPicturesThatHaveThem) { EXPECT_TRUE(Clean(Draw(Flat, 1)).groups.empty()); }

}  // namespace
}  // namespace skywave
