// Compares the view of a map that all builders share, and its summed-area tables, with plain sums.

#include "lights/tables/summed_area_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "base/error.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(SphereMap, SolidAnglesAndDirectionsCoverTheSphere) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {97, 41}, {1024, 512}}) {
    const Image image = test::ConstantMap(width, height, 2);
    const SphereMap map = MakeSphereMap(image);
    double area = 0;
    Vector3 moment;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        area += map.solid_angle[y];
        moment += map.DirectionIntegral(x, y);
        EXPECT_LE(Length(map.DirectionIntegral(x, y)), map.solid_angle[y] * (1 + 1e-12));
      }
    }
    EXPECT_NEAR(area, 4 * kPi, 1e-9);
    EXPECT_NEAR(map.energy, 8 * kPi, 1e-5);
    EXPECT_NEAR(Length(moment), 0, 1e-9);
  }
  const Image image = test::ConstantMap(1024, 512, 1);
  EXPECT_NEAR(MakeSphereMap(image).AreaInPixels(4 * kPi), 333772.72, 1);  // (T table 7.1)
}

TEST(SphereMap, DirectionIntegralsMatchFineSampling) {
  const Image image = test::ConstantMap(8, 5, 1);
  const SphereMap map = MakeSphereMap(image);
  constexpr int kSteps = 200;
  for (int y : {0, 2, 4}) {
    for (int x : {0, 3, 7}) {
      Vector3 sum;
      for (int s = 0; s < kSteps * kSteps; ++s) {
        const double u = (x + (s % kSteps + 0.5) / kSteps) / 8;
        const double v = (y + (s / kSteps + 0.5) / kSteps) / 5;
        const double weight = std::sin(kPi * v) * 2 * kPi * kPi / (40.0 * kSteps * kSteps);
        sum += weight * DirectionOfUv(u, v);
      }
      EXPECT_NEAR(Length(sum - map.DirectionIntegral(x, y)), 0, 1e-5) << x << ", " << y;
    }
  }
}

TEST(SphereMap, NarrowPolarRowsDoNotCancel) {
  const Image image = test::ConstantMap(4, 8192, 1);
  const SphereMap map = MakeSphereMap(image);
  // Next to the pole the integral of sin^2 is h^3 / 3.
  const double h = kPi / 8192, expected = 2 * std::sin(kPi / 4) * h * h * h / 3;
  EXPECT_NEAR(map.horizontal_integral[0] / expected, 1, 1e-6);
  EXPECT_NEAR(map.horizontal_integral[8191] / expected, 1, 1e-6);
}

TEST(SphereMap, UvAndDirectionAreInverse) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 direction = test::RandomDirection(random);
    double u, v;
    UvOfDirection(direction, u, v);
    EXPECT_GE(u, 0);
    EXPECT_LT(u, 1);
    EXPECT_LT(AngleBetween(direction, DirectionOfUv(u, v)), 1e-12);
  }
  const Vector3 right = DirectionOfUv(0.75, 0.5), forward = DirectionOfUv(0.5, 0.5);
  EXPECT_NEAR(right.x, 1, 1e-15);
  EXPECT_NEAR(forward.y, 1, 1e-15);
  EXPECT_NEAR(DirectionOfUv(0.3, 0).z, 1, 1e-15);
}

TEST(SphereMap, RefusesNanInfiniteAndNegativeRadiance) {
  for (float bad :
       {std::numeric_limits<float>::quiet_NaN(), -1e-6f, std::numeric_limits<float>::infinity()}) {
    Image image = test::ConstantMap(4, 2, 1);
    image.Pixel(3, 1)[2] = bad;
    EXPECT_THROW(MakeSphereMap(image), InputError);
  }
  EXPECT_THROW(MakeSphereMap(Image()), InputError);
  const Image black(4, 2);
  EXPECT_EQ(MakeSphereMap(black).energy, 0);
}

TEST(SummedAreaTable, SumsOfRectanglesEqualPlainSums) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    const SphereMap map = MakeSphereMap(image);
    const auto energy = EnergyTable(map);
    const auto moments = MomentTable(map);
    const auto irradiance = IrradianceTable(map);
    std::mt19937 random(3);
    for (int round = 0; round < 20; ++round) {
      Region r = {0, 0, map.width, map.height};
      if (round > 0) {
        r.x0 = int(random() % map.width);
        r.x1 = r.x0 + 1 + int(random() % (map.width - r.x0));
        r.y0 = int(random() % map.height);
        r.y1 = r.y0 + 1 + int(random() % (map.height - r.y0));
      }
      double e = 0, rgb[3] = {};
      Vector3 moment;
      for (int y = r.y0; y < r.y1; ++y) {
        for (int x = r.x0; x < r.x1; ++x) {
          e += map.Energy(x, y);
          moment += map.luminance[std::size_t(y) * map.width + x] * map.DirectionIntegral(x, y);
          for (int c = 0; c < 3; ++c) rgb[c] += image.Pixel(x, y)[c] * map.solid_angle[y];
        }
      }
      const double tolerance = kSumNoise * map.energy + 1e-300;
      EXPECT_NEAR(energy.Sum(r)[0], e, tolerance) << name;
      EXPECT_NEAR(moments.Sum(r)[0], e, tolerance) << name;
      EXPECT_NEAR(moments.Sum(r)[1], moment.x, tolerance) << name;
      EXPECT_NEAR(moments.Sum(r)[2], moment.y, tolerance) << name;
      EXPECT_NEAR(moments.Sum(r)[3], moment.z, tolerance) << name;
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(irradiance.Sum(r)[c], rgb[c], 20 * tolerance) << name;
      }
    }
  }
}

}  // namespace
}  // namespace skywave
