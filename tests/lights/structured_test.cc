// Tests structured importance sampling: cells that keep to thresholds, shares by importance, and
// the covering that farthest-point samples promise.
#include "lights/light_sets/structured.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

// Sets the texels of a rectangle of a black map to one value.
void Paint(Image& image, int x0, int y0, int width, int height, float value) {
  for (int y = y0; y < y0 + height; ++y) {
    for (int x = x0; x < x0 + width; ++x) {
      for (int c = 0; c < 3; ++c) image.Pixel(x % image.width, y)[c] = value;
    }
  }
}

// Returns how many samples lie in each of two halves of the map, left and right of its middle.
std::pair<int, int> Sides(const PlacedCells& cells) {
  const auto left = std::count_if(cells.samples.begin(), cells.samples.end(),
                                  [](const Vector3& sample) { return sample.x < 0; });
  return {int(left), int(cells.samples.size()) - int(left)};
}

TEST(Structured, EveryLitTexelIsInTheCellOfASample) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    SCOPED_TRACE(name);
    const SphereMap map = MakeSphereMap(image);
    for (const int count : {1, 2, 7, 64}) {
      const PlacedCells cells = StructuredCells(map, count);
      EXPECT_EQ(cells.samples.empty(), map.energy <= 0);
      EXPECT_LE(cells.samples.size(), std::size_t(count));
      for (std::size_t i = 0; i < map.texels(); ++i) {
        if (map.luminance[i] <= 0) continue;
        ASSERT_LT(cells.cell_of_texel[i], cells.samples.size()) << "texel " << i;
      }
      for (const CellSums& cell : SumCells(map, cells.cell_of_texel, cells.samples.size())) {
        EXPECT_GT(cell.energy, 0);
      }
    }
  }
}

// A map of one luminance is one part, in which samples are as far apart as they cover.
TEST(Structured, FarthestPointsCoverThePartAsCloselyAsTheyAreApart) {
  const Image image = test::ConstantMap(96, 48, 2);
  const SphereMap map = MakeSphereMap(image);
  const PlacedCells cells = StructuredCells(map, 40);
  ASSERT_EQ(cells.samples.size(), 40u);
  double apart = std::numeric_limits<double>::infinity(), radius = 0;
  for (std::size_t i = 0; i < cells.samples.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      apart = std::min(apart, AngleBetween(cells.samples[i], cells.samples[j]));
    }
  }
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const std::uint32_t own = cells.cell_of_texel[std::size_t(y * map.width + x)];
      double nearest = std::numeric_limits<double>::infinity();
      for (const Vector3& sample : cells.samples) {
        nearest = std::min(nearest, AngleBetween(sample, map.TexelCentre(x, y)));
      }
      EXPECT_NEAR(AngleBetween(cells.samples[own], map.TexelCentre(x, y)), nearest, 1e-12);
      radius = std::max(radius, nearest);
    }
  }
  EXPECT_LE(radius, apart + 1e-12);
}

// Two suns above the highest threshold, wrapped around the seam or not, on a dim sky.
TEST(Structured, CellsOfASunKeepToItsTexels) {
  for (const int x0 : {20, 62}) {
    Image image = test::ConstantMap(64, 32, 0.01f);
    Paint(image, x0, 14, 4, 4, 100);
    const SphereMap map = MakeSphereMap(image);
    const PlacedCells cells = StructuredCells(map, 24);
    std::vector<int> of_sun(cells.samples.size()), of_sky(cells.samples.size());
    for (std::size_t i = 0; i < map.texels(); ++i) {
      ++(map.luminance[i] > 1 ? of_sun : of_sky)[cells.cell_of_texel[i]];
    }
    int suns = 0;
    for (std::size_t cell = 0; cell < of_sun.size(); ++cell) {
      EXPECT_TRUE(of_sun[cell] == 0 || of_sky[cell] == 0) << "cell " << cell;
      suns += of_sun[cell] > 0;
    }
    EXPECT_GT(suns, 4);
    EXPECT_LT(suns, 24);
  }
}

// Importance is energy times the fourth root of the solid angle: of equal suns one with three times
// the light has three times the samples, and one with the same light in 16 times the area twice.
TEST(Structured, SunsShareSamplesByEnergyAndTheRootOfTheirSize) {
  Image brighter(512, 256);
  Paint(brighter, 120, 128, 8, 8, 300);
  Paint(brighter, 380, 128, 8, 8, 100);
  EXPECT_EQ(Sides(StructuredCells(MakeSphereMap(brighter), 40)), std::pair(30, 10));
  Image larger(512, 256);
  Paint(larger, 120, 127, 8, 8, 100);
  Paint(larger, 380, 127, 2, 2, 1600);
  const auto [left, right] = Sides(StructuredCells(MakeSphereMap(larger), 6));
  EXPECT_EQ(left, 4);
  EXPECT_EQ(right, 2);
}

// Suns with a dark column between them are parts of their own, with a sample each.
TEST(Structured, SunsThatDoNotTouchArePartsOfTheirOwn) {
  Image image(64, 32);
  Paint(image, 20, 14, 4, 4, 100);
  Paint(image, 25, 14, 4, 4, 100);
  const SphereMap map = MakeSphereMap(image);
  const PlacedCells cells = StructuredCells(map, 2);
  ASSERT_EQ(cells.samples.size(), 2u);
  const auto cell = [&](int x, int y) { return cells.cell_of_texel[std::size_t(y * 64 + x)]; };
  for (int y = 14; y < 18; ++y) {
    for (int x = 0; x < 4; ++x) {
      EXPECT_EQ(cell(20 + x, y), cell(20, 14));
      EXPECT_EQ(cell(25 + x, y), cell(25, 14));
    }
  }
  EXPECT_NE(cell(20, 14), cell(25, 14));
}

// Beyond the widest solid angle area counts no more.
TEST(Structured, WideSunsShareSamplesByEnergy) {
  Image image(512, 256);
  Paint(image, 64, 112, 64, 32, 100);   // 0.3 sr
  Paint(image, 380, 120, 32, 16, 400);  // a quarter of it
  const auto [left, right] = Sides(StructuredCells(MakeSphereMap(image), 40));
  EXPECT_NEAR(left, 20, 1);
  EXPECT_EQ(left + right, 40);
}

// A part that has too little for a sample is in a cell of the part around it.
TEST(Structured, FaintSpotsJoinTheirSurroundings) {
  Image image = test::ConstantMap(128, 64, 1);
  Paint(image, 30, 30, 1, 1, 40);
  const SphereMap map = MakeSphereMap(image);
  const PlacedCells cells = StructuredCells(map, 1);
  ASSERT_EQ(cells.samples.size(), 1u);
  EXPECT_TRUE(std::all_of(cells.cell_of_texel.begin(), cells.cell_of_texel.end(),
                          [](std::uint32_t cell) { return cell == 0; }));
}

TEST(Structured, NoLightsAreRefused) {
  const Image image = test::ConstantMap(8, 4, 1);
  EXPECT_THROW(StructuredCells(MakeSphereMap(image), 0), InputError);
}

}  // namespace
}  // namespace skywave
