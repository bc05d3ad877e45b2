// Tests what the strategy `visibility` learns; its promises as a strategy are tested by
// strategy_test.
#include "lights/strategies/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/adversarial_maps.h"
#include "tests/support/map_cells.h"
#include "tests/support/shade_points.h"
#include "tests/support/taught_visibility.h"

namespace skywave {
namespace {

const EnvironmentMap& NoiseMap() {
  static const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[0].map_from_world};
  return map;
}

// Draws samples of surfaces with a normal at a point of the unit sphere.
soa::Table<LightColumns> Draw(const EnvStrategy& strategy, Vec point, Vec normal) {
  constexpr std::uint32_t kRows = 4096;
  soa::Table<SurfaceColumns> surfaces(kRows);
  for (std::uint32_t i = 0; i < kRows; ++i) {
    PutSurface(normal, i, surfaces);
    Put(point, i, surfaces->org_x, surfaces->org_y, surfaces->org_z);
  }
  soa::Table<LightColumns> out(kRows);
  strategy.Sample(LambertPoints(surfaces, kRows), RandomUniforms(kRows, 3), kRows, {}, out);
  return out;
}

// Returns the share of samples whose direction has a positive x.
double ShareOfPositiveX(const EnvStrategy& strategy, Vec point, Vec normal) {
  const auto samples = Draw(strategy, point, normal);
  return double(std::count_if(samples->dir_x, samples->dir_x + samples.rows(),
                              [](float x) { return x > 0; })) /
         samples.rows();
}

TEST(Visibility, SamplesGoWhereLightArrives) {
  const VisibilityStrategy strategy(NoiseMap(), {.compensate = 0});
  auto rays = RaysFromSphere(strategy, 200000,
                             [](Vec point, Vec to) { return (to.x > 0) == (point.z > 0); });
  const auto taught = strategy.Taught(rays, kTaughtBox);
  // The normal is the same on both sides, so the place makes the difference.
  const Vec up = {0, 1, 0};
  EXPECT_NEAR(ShareOfPositiveX(strategy, Unit({0, 1, 0.5}), up), 0.5, 0.1);
  EXPECT_GT(ShareOfPositiveX(*taught, Unit({0, 1, 0.5}), up), 0.75);
  EXPECT_LT(ShareOfPositiveX(*taught, Unit({0, 1, -0.5}), up), 0.25);
}

// Two sides of a thin wall have the same points and opposite normals.
TEST(Visibility, TwoSidesOfAWallAreTwoPlaces) {
  const VisibilityStrategy strategy(NoiseMap(), {.compensate = 0});
  std::vector<VisibilityRay> rays;
  Random random(5);
  for (int i = 0; i < 100000; ++i) {
    const Vec normal = {0, i % 2 == 0 ? 1.0 : -1.0, 0};
    const Vec point = {0.2 * random.Direction().x, 0, 0.2 * random.Direction().z};
    Vec to = random.Direction();
    if (Dot(to, normal) < 0) to = -to;
    rays.push_back(RayOf(strategy, point, normal, to, to.x * normal.y > 0));
  }
  const auto taught = strategy.Taught(rays, kTaughtBox);
  EXPECT_GT(ShareOfPositiveX(*taught, {0, 0, 0}, {0, 1, 0}), 0.75);
  EXPECT_LT(ShareOfPositiveX(*taught, {0, 0, 0}, {0, -1, 0}), 0.25);
}

TEST(Visibility, TheOrderOfRaysDoesNotMatter) {
  const VisibilityStrategy strategy(NoiseMap(), {});
  const auto open = [](Vec point, Vec to) { return to.x * point.y > 0.1; };
  auto rays = RaysFromSphere(strategy, 50000, open);
  const auto one = strategy.Taught(rays, kTaughtBox);
  std::rotate(rays.begin(), rays.begin() + 12345, rays.end());
  std::reverse(rays.begin() + 999, rays.end());
  const auto two = strategy.Taught(rays, kTaughtBox);
  ASSERT_GT(one->learnt(), 4u);
  for (const Vec normal : {Vec{1, 0, 0}, Vec{0, -1, 0}, Vec{0, 0, 1}}) {
    EXPECT_EQ(ColumnBits(Draw(*one, normal, normal).columns(), 4096),
              ColumnBits(Draw(*two, normal, normal).columns(), 4096));
  }
}

TEST(Visibility, TheNumberOfPlacesBoundsTheMemory) {
  for (const int places : {16, 64, 1000}) {
    const VisibilityStrategy strategy(NoiseMap(), {.cells = 64, .places = places});
    auto rays = RaysFromSphere(strategy, 400000, [](Vec p, Vec to) { return to.x * p.y > 0.2; });
    const auto taught = strategy.Taught(rays, kTaughtBox);
    EXPECT_LE(taught->learnt(), std::size_t(places));
    // A place has at most one node of two levels and 64 floats, and some words of the octree.
    EXPECT_LE(taught->table_bytes() - strategy.table_bytes(), std::size_t(places) * 512 + 4096);
  }
}

// However wrong what was learnt is, no sample weighs more than a defensive one.
TEST(Visibility, WeightsAreBounded) {
  constexpr double kDefensive = 0.25;
  const VisibilityStrategy strategy(NoiseMap(), {.compensate = 0, .defensive = kDefensive});
  auto rays = RaysFromSphere(strategy, 200000, [](Vec, Vec to) { return to.y > 0.9; });
  const auto taught = strategy.Taught(rays, kTaughtBox);
  ASSERT_GT(taught->learnt(), 0u);
  const auto heaviest = [](const soa::Table<LightColumns>& samples) {
    double most = 0;
    for (std::uint32_t i = 0; i < samples.rows(); ++i) {
      const float rgb[3] = {samples->r[i], samples->g[i], samples->b[i]};
      const float luminance = Luminance(rgb);
      if (luminance > 0) most = std::max(most, double(luminance) / double(samples->pdf[i]));
    }
    return most;
  };
  for (const Vec normal : {Vec{0, 1, 0}, Vec{1, 0, 0}, Unit({1, 1, 1})}) {
    // Light below the horizon has a tenth of the share of light at the zenith.
    EXPECT_LT(heaviest(Draw(*taught, normal, normal)),
              11.5 / kDefensive * heaviest(Draw(strategy, normal, normal)));
  }
}

}  // namespace
}  // namespace skywave
