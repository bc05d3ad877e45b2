// Tests lights of cells: every method conserves energy for every map and count; also tests
// positions and degenerate cells.

#include "lights/tables/cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "lights/light_sets/clustering.h"
#include "lights/light_sets/median_cut.h"
#include "lights/light_sets/penrose.h"
#include "lights/light_sets/strata.h"
#include "lights/light_sets/variance_cut.h"
#include "lights/light_sets/voronoi.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

struct Totals {
  double energy = 0, solid_angle = 0;
  std::array<double, 3> rgb = {};
};

Totals Sum(const LightSet& set) {
  Totals totals;
  for (const DirectionalLight& light : set.lights) {
    totals.energy += light.energy;
    totals.solid_angle += light.solid_angle;
    for (int c = 0; c < 3; ++c) totals.rgb[c] += light.irradiance[c];
  }
  return totals;
}

std::array<double, 3> MapIrradiance(const SphereMap& map) {
  std::array<double, 3> sum = {};
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      for (int c = 0; c < 3; ++c) sum[c] += map.image->Pixel(x, y)[c] * map.solid_angle[y];
    }
  }
  return sum;
}

using Method = std::function<LightSet(const SphereMap&, int count)>;

LightSet PenroseLights(const SphereMap& map, int count, LightPosition position, int lloyd) {
  const PenroseSet set = PenroseSamples(ImportancePyramid(map), count);
  return VoronoiLights(map, Directions(set), position, lloyd);
}

std::vector<std::pair<std::string, Method>> Methods() {
  using enum LightPosition;
  return {
      {"median cut", [](const SphereMap& map,
                        int n) { return LightsOfRegions(map, MedianCut(map, n), kCentroid); }},
      {"median cut, middle",
       [](const SphereMap& map, int n) {
         return LightsOfRegions(map, MedianCut(map, n), kSample);
       }},
      {"variance cut", [](const SphereMap& map,
                          int n) { return LightsOfRegions(map, VarianceCut(map, n), kCentroid); }},
      {"penrose", [](const SphereMap& map, int n) { return PenroseLights(map, n, kSample, 0); }},
      {"penrose, centre",
       [](const SphereMap& map, int n) { return PenroseLights(map, n, kCentre, 0); }},
      {"penrose, Lloyd",
       [](const SphereMap& map, int n) { return PenroseLights(map, n, kCentroid, 3); }},
      {"penrose, clustered",
       [](const SphereMap& map, int n) {
         const auto samples = Directions(PenroseSamples(ImportancePyramid(map), 2 * n));
         const auto cells =
             SumCells(map, VoronoiCells(map.width, map.height, samples), samples.size());
         const auto clusters = ClusterPairwise(
             samples, Frequencies(cells, ClusterFrequency::kEnergy), {.clusters = n});
         return VoronoiLights(map, clusters.directions, kCentroid);
       }},
  };
}

TEST(Cells, EveryMethodConservesEnergyOnEveryMapAndCount) {
  for (const auto& [map_name, image] : test::AdversarialMaps()) {
    const SphereMap map = MakeSphereMap(image);
    const auto rgb = MapIrradiance(map);
    for (const auto& [name, method] : Methods()) {
      for (int count : {1, 2, 17, 64, 500}) {
        SCOPED_TRACE(map_name + ", " + name + ", " + std::to_string(count));
        const LightSet set = method(map, count);
        const Totals totals = Sum(set);
        EXPECT_LE(int(set.lights.size()), count);
        EXPECT_EQ(set.lights.empty(), map.energy == 0);
        EXPECT_NEAR(totals.energy, map.energy, 1e-10 * map.energy);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(totals.rgb[c], rgb[c], 1e-10 * rgb[c]);
        EXPECT_LE(totals.solid_angle, 4 * kPi * (1 + 1e-12));
        for (const DirectionalLight& light : set.lights) {
          EXPECT_NEAR(Length(light.direction), 1, 1e-12);
          EXPECT_GT(light.energy, 0);
          const auto& e = light.irradiance;
          EXPECT_NEAR(0.2125 * e[0] + 0.7154 * e[1] + 0.0721 * e[2], light.energy,
                      1e-6 * light.energy);
        }
        // Every lit texel belongs to a light, and no texel to a light that does not exist.
        ASSERT_EQ(set.cell_of_texel.size(), map.texels());
        for (std::size_t i = 0; i < map.texels(); ++i) {
          if (set.cell_of_texel[i] == kNoCell) {
            ASSERT_EQ(map.luminance[i], 0);
          } else {
            ASSERT_LT(set.cell_of_texel[i], set.lights.size());
          }
        }
      }
    }
  }
}

TEST(Cells, StrataHaveTheEnergyOfTheMapTogether) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    SCOPED_TRACE(name);
    const SphereMap map = MakeSphereMap(image);
    const Strata strata = StrataByVariation(map);
    const Image a_image = StratumImage(map, strata, true);
    const Image b_image = StratumImage(map, strata, false);
    const SphereMap a = MakeSphereMap(a_image), b = MakeSphereMap(b_image);
    const LightSet lights_a = PenroseLights(a, 64, LightPosition::kCentroid, 0);
    const LightSet lights_b = LightsOfRegions(b, MedianCut(b, 64), LightPosition::kCentroid);
    EXPECT_NEAR(Sum(lights_a).energy, strata.energy_a, 1e-10 * map.energy);
    EXPECT_NEAR(Sum(lights_b).energy, strata.energy_b, 1e-10 * map.energy);
    EXPECT_NEAR(Sum(lights_a).energy + Sum(lights_b).energy, map.energy, 1e-10 * map.energy);
  }
}

TEST(Cells, SumsMatchAPlainLoop) {
  const Image image = test::NoiseMap(61, 35, 9);
  const SphereMap map = MakeSphereMap(image);
  std::mt19937 random(1);
  CellMap cells(map.texels());
  for (auto& cell : cells) cell = random() % 5 == 0 ? kNoCell : random() % 4;
  std::vector<CellSums> expected(4);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = std::size_t(y) * map.width + x;
      if (cells[i] == kNoCell) continue;
      CellSums& sums = expected[cells[i]];
      sums.energy += map.Energy(x, y);
      sums.solid_angle += map.solid_angle[y];
      sums.energy_moment += double(map.luminance[i]) * map.DirectionIntegral(x, y);
      sums.area_moment += map.DirectionIntegral(x, y);
      for (int c = 0; c < 3; ++c) {
        sums.irradiance[c] += image.Pixel(x, y)[c] * map.solid_angle[y];
      }
    }
  }
  const auto sums = SumCells(map, cells, 4);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(sums[i].energy, expected[i].energy, 1e-12 * expected[i].energy);
    EXPECT_NEAR(sums[i].solid_angle, expected[i].solid_angle, 1e-12);
    EXPECT_NEAR(Length(sums[i].energy_moment - expected[i].energy_moment), 0, 1e-9);
    EXPECT_NEAR(Length(sums[i].area_moment - expected[i].area_moment), 0, 1e-12);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(sums[i].irradiance[c], expected[i].irradiance[c], 1e-9);
    }
  }
}

TEST(Cells, PositionsAreSampleCentreAndCentroid) {
  // All light of this quarter of the sphere comes from one texel.
  Image image(64, 32);
  image.Pixel(40, 12)[1] = 1;
  const SphereMap map = MakeSphereMap(image);
  const Region quarter = {32, 0, 64, 16};
  const auto direction = [&](LightPosition position) {
    const LightSet set = LightsOfRegions(map, std::vector<Region>{quarter}, position);
    EXPECT_EQ(set.lights.size(), 1u);
    EXPECT_EQ(set.cell_of_texel[0], kNoCell);
    return set.lights[0].direction;
  };
  const Vector3 middle = DirectionOfUv(0.75, 0.25);
  EXPECT_LT(AngleBetween(direction(LightPosition::kSample), middle), 1e-12);
  // The centroid of the quarter up and right has equal parts of both.
  EXPECT_LT(AngleBetween(direction(LightPosition::kCentre), NormalizeOr({1, 0, 1}, 1, {})), 1e-12);
  EXPECT_LT(AngleBetween(direction(LightPosition::kCentroid), map.TexelCentre(40, 12)), 1e-3);
}

TEST(Cells, ACellWithoutMeanDirectionKeepsItsSample) {
  const Image image = test::ConstantMap(64, 32, 1);
  const SphereMap map = MakeSphereMap(image);
  const Vector3 sample = DirectionOfUv(0.2, 0.3);
  for (auto position : {LightPosition::kCentre, LightPosition::kCentroid}) {
    const LightSet set = VoronoiLights(map, {sample}, position, 2);
    ASSERT_EQ(set.lights.size(), 1u);
    EXPECT_EQ(set.lights[0].direction, sample);
    EXPECT_NEAR(set.lights[0].solid_angle, 4 * kPi, 1e-9);
  }
}

TEST(Cells, TheSeamDoesNotPullCentroidsApart) {
  Image image(128, 64);
  for (int x : {0, 127}) image.Pixel(x, 30)[1] = 1;
  const SphereMap map = MakeSphereMap(image);
  const LightSet set = VoronoiLights(map, {DirectionOfUv(0.9, 0.5)}, LightPosition::kCentroid);
  EXPECT_LT(AngleBetween(set.lights[0].direction, DirectionOfUv(0, 30.5 / 64)), 2e-3);
}

TEST(Cells, LloydStepsDrawLightsToTheirEnergy) {
  const Image image = test::SunMap(256, 128, 100);
  const SphereMap map = MakeSphereMap(image);
  const auto samples = Directions(PenroseSamples(ImportancePyramid(map), 64));
  const auto spread = [&](int steps) {
    const LightSet set = VoronoiLights(map, samples, LightPosition::kCentroid, steps);
    const auto cells = SumCells(map, set.cell_of_texel, set.lights.size());
    double sum = 0;
    for (const CellSums& cell : cells) {
      const Vector3& m = cell.energy_moment;
      sum += SphericalVariance({cell.energy, m.x, m.y, m.z});
    }
    return sum;
  };
  // One step must follow its definition.
  const auto cells = SumCells(map, VoronoiCells(map.width, map.height, samples), samples.size());
  std::vector<Vector3> moved;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    moved.push_back(NormalizeOr(cells[i].energy_moment, cells[i].energy, samples[i]));
  }
  const LightSet stepped = VoronoiLights(map, samples, LightPosition::kSample, 1);
  const LightSet expected = VoronoiLights(map, moved, LightPosition::kSample);
  ASSERT_EQ(stepped.lights.size(), expected.lights.size());
  for (std::size_t i = 0; i < stepped.lights.size(); ++i) {
    EXPECT_EQ(stepped.lights[i].direction, expected.lights[i].direction);
  }
  const double none = spread(0), one = spread(1), five = spread(5);
  EXPECT_LT(one, none);
  EXPECT_LT(five, one);
}

// A number that selects a light moves over the sphere without jumps: a list in any other order (for
// example that of the samples) has a mean step of a quarter turn.
TEST(Cells, NeighboursInTheListAreNeighboursOnTheSphere) {
  const Image image = [] {
    Image constant(128, 64);
    std::fill(constant.rgb.begin(), constant.rgb.end(), 1.0f);
    return constant;
  }();
  const SphereMap map = MakeSphereMap(image);
  const std::vector<Vector3> samples = Directions(PenroseSamples(ImportancePyramid(map), 500));
  const LightSet set = VoronoiLights(map, samples, LightPosition::kCentroid);
  double sum = 0;
  for (std::size_t i = 1; i < set.lights.size(); ++i) {
    sum += AngleBetween(set.lights[i - 1].direction, set.lights[i].direction);
  }
  const double side = std::sqrt(4 * kPi / double(set.lights.size()));
  EXPECT_LT(sum / double(set.lights.size() - 1), 1.5 * side);
}

// Maps of more than 64 rows are summed in bands. Where every texel has light, the cells are the
// sphere, and the moments of their areas cancel.
TEST(Cells, OfHighMapsCoverTheSphere) {
  const Image image = test::NoiseMap(200, 100, 5);
  const SphereMap map = MakeSphereMap(image);
  std::mt19937 random(2);
  std::vector<Vector3> samples;
  for (int i = 0; i < 20; ++i) samples.push_back(test::RandomDirection(random));
  const auto cells = SumCells(map, VoronoiCells(map.width, map.height, samples), samples.size());
  double solid_angle = 0, energy = 0;
  Vector3 moment;
  for (const CellSums& cell : cells) {
    solid_angle += cell.solid_angle, energy += cell.energy;
    moment += cell.area_moment;
  }
  EXPECT_NEAR(solid_angle, 4 * kPi, 1e-9);
  EXPECT_NEAR(energy, map.energy, 1e-10 * map.energy);
  EXPECT_LT(Length(moment), 1e-9);
}

}  // namespace
}  // namespace skywave
