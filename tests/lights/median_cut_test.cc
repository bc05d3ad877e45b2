// Tests median cut and variance cut: exact cover, even energy, any count and degenerate maps.

#include "lights/light_sets/median_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/variance_cut.h"
#include "lights/tables/cells.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

double PlainEnergy(const SphereMap& map, const Region& r) {
  double energy = 0;
  for (int y = r.y0; y < r.y1; ++y) {
    for (int x = r.x0; x < r.x1; ++x) energy += map.Energy(x, y);
  }
  return energy;
}

int LitTexels(const SphereMap& map) {
  return int(std::count_if(map.luminance.begin(), map.luminance.end(),
                           [](float luminance) { return luminance > 0; }));
}

void ExpectExactCover(const SphereMap& map, const std::vector<Region>& regions) {
  std::vector<int> covered(map.texels());
  for (const Region& r : regions) {
    ASSERT_TRUE(0 <= r.x0 && r.x0 < r.x1 && r.x1 <= map.width);
    ASSERT_TRUE(0 <= r.y0 && r.y0 < r.y1 && r.y1 <= map.height);
    for (int y = r.y0; y < r.y1; ++y) {
      for (int x = r.x0; x < r.x1; ++x) ++covered[std::size_t(y) * map.width + x];
    }
  }
  EXPECT_TRUE(std::all_of(covered.begin(), covered.end(), [](int n) { return n == 1; }));
}

// Debevec compares angles, the thesis lengths in (u, v), where a strip at a pole is long.
TEST(Cuts, LightsByMedianCutCompareTheSidesThatTheyAreToldTo) {
  const Image image = test::SunMap(64, 32, 40);
  const SphereMap map = MakeSphereMap(image);
  const auto cells = [&](LongestSide longest) {
    return BuildLights(map, {.source = LightSource::kMedianCut, .lights = 20, .longest = longest})
        .cell_of_texel;
  };
  const auto expected = [&](bool scale_width) {
    return LightsOfRegions(map, MedianCut(map, 20, {.scale_width = scale_width}),
                           LightPosition::kCentroid)
        .cell_of_texel;
  };
  EXPECT_EQ(cells(LongestSide::kAngle), expected(true));
  EXPECT_EQ(cells(LongestSide::kUv), expected(false));
  EXPECT_NE(expected(true), expected(false));
}

TEST(Cuts, CoverEveryMapOnceWithTheRequestedCount) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    SCOPED_TRACE(name);
    const SphereMap map = MakeSphereMap(image);
    for (int count : {1, 2, 3, 7, 64, 100}) {
      for (const bool variance : {false, true}) {
        const auto regions = variance ? VarianceCut(map, count) : MedianCut(map, count);
        if (map.energy == 0) {
          EXPECT_TRUE(regions.empty());
          continue;
        }
        ExpectExactCover(map, regions);
        EXPECT_EQ(int(regions.size()), std::min(count, LitTexels(map)));
        for (const Region& region : regions) EXPECT_GT(PlainEnergy(map, region), 0);
      }
    }
  }
}

TEST(Cuts, RefuseNoLights) {
  const Image image = test::ConstantMap(4, 2, 1);
  EXPECT_THROW(MedianCut(MakeSphereMap(image), 0), InputError);
  EXPECT_THROW(VarianceCut(MakeSphereMap(image), -3), InputError);
}

TEST(MedianCut, PowersOfTwoHaveEqualEnergyWhereTexelsAreFine) {
  const Image image = test::SunMap(512, 256, 1);
  const SphereMap map = MakeSphereMap(image);
  for (int count : {2, 16, 64}) {
    for (const Region& region : MedianCut(map, count)) {
      EXPECT_NEAR(PlainEnergy(map, region) * count / map.energy, 1, 0.15);
    }
  }
}

TEST(MedianCut, OtherCountsSplitTheLargestFirst) {
  const Image image = test::SunMap(512, 256, 1);
  const SphereMap map = MakeSphereMap(image);
  double smallest = 1e300, largest = 0;
  for (const Region& region : MedianCut(map, 100)) {
    const double energy = PlainEnergy(map, region) / map.energy;
    smallest = std::min(smallest, energy);
    largest = std::max(largest, energy);
  }
  EXPECT_LT(largest, 1.2 / 64);
  EXPECT_GT(smallest, 0.8 / 128);
}

TEST(MedianCut, CutsTheLongestSideOnTheSphere) {
  const Image image = test::ConstantMap(64, 32, 1);
  const SphereMap map = MakeSphereMap(image);
  const auto halves = MedianCut(map, 2);
  EXPECT_EQ(halves[0], (Region{0, 0, 32, 32}));  // 2 pi wide, pi high
  EXPECT_EQ(halves[1], (Region{32, 0, 64, 32}));
  // The lit polar band of 64 x 8 texels is 2 pi wide in (u, v), but at most pi sin(pi / 8) = 0.38
  // pi wide by the scaled rule; the second cut distinguishes the rules.
  Image band(64, 32);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 64; ++x) band.Pixel(x, y)[1] = 1;
  }
  const SphereMap polar = MakeSphereMap(band);
  const auto scaled = MedianCut(polar, 16), plain = MedianCut(polar, 16, {.scale_width = false});
  const auto same = [&](const auto& a, const auto& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  };
  EXPECT_FALSE(same(scaled, plain));
  const auto rows_cut = [](const std::vector<Region>& regions) {
    return std::count_if(regions.begin(), regions.end(), [](Region r) { return r.y0 > 0; });
  };
  EXPECT_GT(rows_cut(scaled), rows_cut(plain));
}

TEST(MedianCut, ASunInOneTexelIsOneRegionOfIts) {
  Image image = test::ConstantMap(64, 32, 1e-3f);
  image.Pixel(20, 10)[1] = 1e6f;
  const SphereMap map = MakeSphereMap(image);
  const auto regions = MedianCut(map, 64);
  EXPECT_EQ(regions.size(), 64u);
  EXPECT_EQ(std::count(regions.begin(), regions.end(), Region{20, 10, 21, 11}), 1);
}

TEST(VarianceCut, VarianceIsTheMeanSquareDistanceFromTheCentroid) {
  // Two equal lights at a right angle have |S|^2 = 2, which gives 2 - 2 / 2.
  EXPECT_NEAR(SphericalVariance({2, 1, 1, 0}), 1, 1e-15);
  EXPECT_EQ(SphericalVariance({3, 3, 0, 0}), 0);
  EXPECT_EQ(SphericalVariance({0, 0, 0, 0}), 0);
  EXPECT_GE(SphericalVariance({1, 1 + 1e-15, 0, 0}), 0);
}

TEST(VarianceCut, FirstCutIsTheBestOfAll) {
  const Image image = test::NoiseMap(24, 13, 11);
  const SphereMap map = MakeSphereMap(image);
  const auto variance = [&](const Region& r) {
    std::array<double, 4> m = {};
    for (int y = r.y0; y < r.y1; ++y) {
      for (int x = r.x0; x < r.x1; ++x) {
        const double l = map.luminance[std::size_t(y) * map.width + x];
        const Vector3 d = l * map.DirectionIntegral(x, y);
        m[0] += map.Energy(x, y), m[1] += d.x, m[2] += d.y, m[3] += d.z;
      }
    }
    return SphericalVariance(m);
  };
  double best = 1e300;
  for (int x = 1; x < 24; ++x) {
    best = std::min(best, variance({0, 0, x, 13}) + variance({x, 0, 24, 13}));
  }
  for (int y = 1; y < 13; ++y) {
    best = std::min(best, variance({0, 0, 24, y}) + variance({0, y, 24, 13}));
  }
  const auto regions = VarianceCut(map, 2);
  EXPECT_NEAR(variance(regions[0]) + variance(regions[1]), best, 1e-9 * best);
  // The next cut divides the region of larger variance.
  const auto three = VarianceCut(map, 3);
  const Region& kept = variance(regions[0]) > variance(regions[1]) ? regions[1] : regions[0];
  EXPECT_EQ(std::count(three.begin(), three.end(), kept), 1);
}

TEST(VarianceCut, LightsAreNearerToTheMapThanMedianCut) {
  const Image image = test::SunMap(256, 128, 100);
  const SphereMap map = MakeSphereMap(image);
  const auto spread = [&](const std::vector<Region>& regions) {
    double sum = 0;
    const CellMap cells = CellsOfRegions(map.width, map.height, regions);
    for (const CellSums& cell : SumCells(map, cells, regions.size())) {
      const Vector3& m = cell.energy_moment;
      sum += SphericalVariance({cell.energy, m.x, m.y, m.z});
    }
    return sum;
  };
  EXPECT_LT(spread(VarianceCut(map, 64)), 0.7 * spread(MedianCut(map, 64)));
}

}  // namespace
}  // namespace skywave
