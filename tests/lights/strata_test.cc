// Tests strata: prefixes of the sorted texels by fraction, by lights and by maximum variation.

#include "lights/light_sets/strata.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

void ExpectConsistent(const SphereMap& map, const Strata& strata) {
  double energy[2] = {}, area[2] = {};
  std::size_t texels[2] = {};
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = std::size_t(y) * map.width + x;
      const int a = strata.in_a[i];
      energy[a] += map.Energy(x, y);
      area[a] += map.solid_angle[y];
      ++texels[a];
      if (a) {
        EXPECT_GE(map.luminance[i], strata.threshold);
      } else {
        EXPECT_LE(map.luminance[i], strata.threshold);
      }
    }
  }
  EXPECT_NEAR(strata.energy_a, energy[1], 1e-12 * map.energy);
  EXPECT_NEAR(strata.energy_b, energy[0], 1e-12 * map.energy);
  EXPECT_NEAR(strata.solid_angle_a, area[1], 1e-10);
  EXPECT_NEAR(strata.solid_angle_b, area[0], 1e-10);
  EXPECT_EQ(strata.texels_a, texels[1]);
  EXPECT_EQ(strata.texels_b, texels[0]);
  EXPECT_NEAR(strata.p * map.energy, energy[1], 1e-12 * map.energy);
}

TEST(Strata, PartitionEveryMap) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    SCOPED_TRACE(name);
    const SphereMap map = MakeSphereMap(image);
    for (double p : {0.0, 0.1, 0.5, 0.999, 1.0}) ExpectConsistent(map, StrataByFraction(map, p));
    ExpectConsistent(map, StrataByLights(map, 64, 0.1));
    ExpectConsistent(map, StrataByVariation(map));
  }
}

TEST(Strata, FractionIsTheShortestPrefix) {
  const Image image = test::SunMap(128, 64, 50);
  const SphereMap map = MakeSphereMap(image);
  for (double p : {0.01, 0.3, 0.7, 1.0}) {
    const Strata strata = StrataByFraction(map, p);
    EXPECT_GE(strata.p, p - 1e-11);
    EXPECT_LE(strata.p, p + strata.threshold * map.solid_angle[32] / map.energy);
  }
  EXPECT_EQ(StrataByFraction(map, 0).texels_a, 0u);
  EXPECT_EQ(StrataByFraction(map, 1).energy_b, 0);
}

TEST(Strata, LightsTakeTheRoomOfTheirCaps) {
  const Image image = test::NoiseMap(256, 128, 3);
  const SphereMap map = MakeSphereMap(image);
  const double separation = 5 * kPi / 180, cap = 2 * kPi * (1 - std::cos(separation / 2));
  for (int lights : {0, 1, 10, 100}) {
    const Strata strata = StrataByLights(map, lights, separation);
    EXPECT_GE(strata.solid_angle_a, lights * cap - 1e-9);
    EXPECT_LE(strata.solid_angle_a, lights * cap + map.solid_angle[64]);
    // The formula of T 7.15 is W H / pi N (1 - cos(alpha / 2)) pixels.
    EXPECT_NEAR(map.AreaInPixels(strata.solid_angle_a),
                256 * 128 / kPi * lights * (1 - std::cos(separation / 2)), 1);
  }
  EXPECT_EQ(StrataByLights(map, 1000000, 1).texels_b, 0u);
}

TEST(Strata, MaximumVariationFindsTheKneeOfTwoLevels) {
  // With ten bright texels on a dim map, the two trapezia fit when A consists of the ten.
  Image image = test::ConstantMap(64, 32, 0.01f);
  for (int x = 10; x < 20; ++x) image.Pixel(x, 16)[1] = 100;
  const SphereMap map = MakeSphereMap(image);
  double zeta = 0;
  const Strata strata = StrataByVariation(map, &zeta);
  // zeta drops sharply at the first dim texel, the smallest minimiser.
  EXPECT_EQ(strata.texels_a, 11u);
  EXPECT_GT(strata.p, 0.5);
  const double dim = map.luminance[0], bright = map.luminance[16 * 64 + 10];
  const double all = map.AreaInPixels(4 * kPi), x = map.AreaInPixels(strata.solid_angle_a);
  EXPECT_NEAR(zeta, (bright + dim) / 2 * x + dim * (all - x), 1e-6 * zeta);
}

TEST(Strata, MaximumVariationMinimisesZeta) {
  const Image image = test::NoiseMap(40, 20, 4);
  const SphereMap map = MakeSphereMap(image);
  double zeta = 0;
  const Strata strata = StrataByVariation(map, &zeta);
  std::vector<std::pair<float, int>> sorted;
  for (int i = 0; i < 800; ++i) sorted.push_back({-map.luminance[i], i});
  std::sort(sorted.begin(), sorted.end());
  double x = 0, best = 1e300;
  std::size_t best_count = 0;
  const double psi = map.AreaInPixels(4 * kPi), first = -sorted[0].first, last = -sorted[799].first;
  for (std::size_t i = 0; i < 800; ++i) {
    x += map.AreaInPixels(map.solid_angle[sorted[i].second / 40]);
    const double f = -sorted[i].first;
    const double value = (first + f) / 2 * x + (f + last) / 2 * (psi - x);
    if (value < best) best = value, best_count = i + 1;
  }
  EXPECT_EQ(strata.texels_a, best_count);
  EXPECT_NEAR(zeta, best, 1e-9 * best);
}

// g grows to the energy of the map, f falls from the brightest texel to the dimmest one, and zeta
// is least where the division by variation ends A.
TEST(Strata, PrefixesHaveTheFunctionsOfTheDivision) {
  const Image image = test::SunMap(64, 32, 1024);
  const SphereMap map = MakeSphereMap(image);
  const std::vector<StratumPrefix> all = PrefixesOf(map, map.texels());
  const Strata strata = StrataByVariation(map);
  const auto least = std::min_element(all.begin(), all.end(),
                                      [](const auto& a, const auto& b) { return a.zeta < b.zeta; });
  EXPECT_NEAR(least->area, strata.solid_angle_a, 0.02 * strata.solid_angle_a);
  for (const std::size_t most : {2u, 50u, 3000u}) {
    const std::vector<StratumPrefix> prefixes = PrefixesOf(map, most);
    ASSERT_LE(prefixes.size(), most);
    EXPECT_GE(prefixes.size(), std::min<std::size_t>(most, 30));
    EXPECT_EQ(float(prefixes.front().luminance),
              *std::max_element(map.luminance.begin(), map.luminance.end()));
    EXPECT_EQ(float(prefixes.back().luminance),
              *std::min_element(map.luminance.begin(), map.luminance.end()));
    EXPECT_NEAR(prefixes.back().area, 4 * std::numbers::pi, 1e-9);
    EXPECT_NEAR(prefixes.back().energy, map.energy, 1e-9 * map.energy);
    for (std::size_t i = 1; i < prefixes.size(); ++i) {
      EXPECT_GT(prefixes[i].area, prefixes[i - 1].area);
      EXPECT_LE(prefixes[i].luminance, prefixes[i - 1].luminance);
      EXPECT_GE(prefixes[i].energy, prefixes[i - 1].energy);
    }
  }
}

TEST(Strata, MapsWithoutVariationHaveAnEmptyA) {
  for (const Image& image :
       {test::ConstantMap(16, 8, 2), Image(16, 8), test::ConstantMap(1, 1, 1)}) {
    const Strata strata = StrataByVariation(MakeSphereMap(image));
    EXPECT_EQ(strata.texels_a, 0u);
    EXPECT_EQ(strata.p, 0);
    EXPECT_EQ(strata.threshold, INFINITY);
  }
}

TEST(Strata, ImagesOfTheStrataAddUpToTheMap) {
  const Image image = test::SunMap(64, 32, 1000);
  const SphereMap map = MakeSphereMap(image);
  const Strata strata = StrataByFraction(map, 0.4);
  const Image a = StratumImage(map, strata, true), b = StratumImage(map, strata, false);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    EXPECT_EQ(a.rgb[i] + b.rgb[i], image.rgb[i]);
    EXPECT_EQ(a.rgb[i] * b.rgb[i], 0);
    EXPECT_EQ(a.rgb[i] != 0, strata.in_a[i / 3] != 0);
  }
}

TEST(Strata, RefuseParametersOutOfRange) {
  const Image image = test::ConstantMap(4, 2, 1);
  const SphereMap map = MakeSphereMap(image);
  EXPECT_THROW(StrataByFraction(map, -0.1), InputError);
  EXPECT_THROW(StrataByFraction(map, 1.1), InputError);
  EXPECT_THROW(StrataByFraction(map, NAN), InputError);
  EXPECT_THROW(StrataByLights(map, -1, 0.1), InputError);
  EXPECT_THROW(StrataByLights(map, 4, 7), InputError);
  EXPECT_THROW(StrataByLights(map, 4, NAN), InputError);
}

TEST(Strata, ZetaOfAConstantMapIsItsLight) {
  const Image image = test::ConstantMap(16, 8, 3);
  double zeta = 0;
  StrataByVariation(MakeSphereMap(image), &zeta);
  EXPECT_NEAR(zeta, 3 * 2 * 16 * 8 / kPi, 1e-4);
}

}  // namespace
}  // namespace skywave
