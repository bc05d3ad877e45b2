// Tests the densities that plots show against sums over the texels.
#include "lights/probe/densities.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

TEST(Densities, AreThoseOfTexelsAndIntegrateToOne) {
  const Image image = test::SunMap(32, 16, 64);
  const SphereMap map = MakeSphereMap(image);
  const TexelDensity1D columns = ColumnDensity(map);
  ASSERT_EQ(columns.density.size(), 32u);
  double sum = 0;
  for (int x = 0; x < 32; ++x) {
    double energy = 0;
    for (int y = 0; y < 16; ++y) energy += map.Energy(x, y);
    EXPECT_NEAR(columns.density[std::size_t(x)], 32 * energy / map.energy, 1e-9);
    sum += energy / map.energy;
    EXPECT_NEAR(columns.cumulative[std::size_t(x)], sum, 1e-9);
    const TexelDensity1D rows = RowDensity(map, x);
    EXPECT_NEAR(rows.cumulative.back(), 1, 1e-12);
    for (int y = 0; y < 16; ++y) {
      EXPECT_NEAR(rows.density[std::size_t(y)], 16 * map.Energy(x, y) / energy, 1e-9);
    }
  }
  const int brightest = BrightestColumn(map);
  const Image joint = JointDensity(map);
  for (int x = 0; x < 32; ++x) {
    for (int y = 0; y < 16; ++y) {
      EXPECT_LE(map.Energy(x, y), [&] {
        double most = 0;
        for (int row = 0; row < 16; ++row) {
          most = std::max(most, map.Energy(brightest, row));
        }
        return most;
      }());
      const double scale = map.solid_angle[std::size_t(y)] / map.solid_angle[8];
      EXPECT_NEAR(joint.Pixel(x, y)[1], image.Pixel(x, y)[1] * scale, 1e-5 * image.Pixel(x, y)[1]);
    }
  }
}

TEST(Densities, OfABlackMapAreZero) {
  const Image image(8, 4);
  const TexelDensity1D columns = ColumnDensity(MakeSphereMap(image));
  EXPECT_EQ(columns.density, std::vector<double>(8, 0.0));
  EXPECT_EQ(columns.cumulative, std::vector<double>(8, 0.0));
}

}  // namespace
}  // namespace skywave
