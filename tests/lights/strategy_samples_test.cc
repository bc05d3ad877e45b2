// Holds what single strategies promise beyond the suite of all: candidates of ris, merged lights.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "kernels/sampler.h"
#include "lights/strategies/strategy.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/map_cells.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"

namespace skywave {
namespace {

constexpr std::uint32_t kSamples = 40000;
const Vec kNormal = Unit({0.3, 0.8, 0.5});

// The mean of four light samples varies about a quarter as much as one, which it could not if they
// chose from the same candidates.
TEST(StrategySamples, LightSamplesOfRisHaveCandidatesOfTheirOwn) {
  constexpr std::uint32_t kRows = 4096, kLights = 4;
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world, {}};
  const auto strategy = MakeStrategy("ris", map);
  const auto surfaces = SurfacesWith(kNormal, kRows);
  const LambertPoints points(surfaces, kRows);
  std::vector<double> sums(kRows);
  Moments one, mean;
  for (std::uint32_t index = 0; index < kLights; ++index) {
    soa::Table<LightColumns> out(kRows);
    strategy->Sample(points, RandomUniforms(kRows, 60 + index), kRows,
                     {.index = index, .requested = kLights}, out);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const Vec direction = Get(i, out->dir_x, out->dir_y, out->dir_z);
      const double light =
          Weighted(out->r[i], out->g[i], out->b[i]) * std::max(0.0, Dot(direction, kNormal));
      one.Add(kLights * light), sums[i] += light;
    }
  }
  for (const double sum : sums) mean.Add(sum);
  EXPECT_LT(mean.variance(), 0.3 * one.variance());
}

// In a picture the caller's uniforms and those of the candidates belong to the same path. If they
// were the same ones, the choice among candidates would depend on where these are.
TEST(StrategySamples, RisChoosesIndependentlyOfItsCandidates) {
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world, {}};
  const auto surfaces = SurfacesWith(kNormal, kSamples);
  const LambertPoints lambert(surfaces, kSamples);
  const ShadePoints points = lambert;
  const std::uint32_t pair = SamplePair(0, SampleUse::kLight);
  const soa::Table<UniformColumns> uniforms(kSamples);
  DrawUniforms(points.paths, surfaces->path, kSamples, pair, {}, uniforms);
  // Whatever is chosen, the luminance of what it reflects is the same, but not what else it meets.
  const Vec side = Unit(Cross(kNormal, {0, 0, 1}));
  const auto response = [&](Vec direction) {
    return std::max(0.0, Dot(direction, kNormal)) * std::pow(1 + Dot(direction, side), 2);
  };
  const MapCells cells(map);
  const Image held = HeldMap(map);
  double exact = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Vec direction = cells.directions()[i];
    double u, v;
    MapPosition(map.map_from_world, direction, u, v);
    const float* rgb = held.Pixel(std::min(int(u * held.width), held.width - 1),
                                  std::min(int(v * held.height), held.height - 1));
    exact += Weighted(rgb[0], rgb[1], rgb[2]) * response(direction) * cells.solid_angle(i);
  }
  for (const char* const specification : {"ris:map=1,bsdf=1", "ris:map=4,bsdf=0", "ris"}) {
    soa::Table<LightColumns> out(kSamples);
    MakeStrategy(specification, map)->Sample(points, uniforms, kSamples, {.pair = pair}, out);
    Moments moments;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const Vec direction = Get(i, out->dir_x, out->dir_y, out->dir_z);
      moments.Add(Weighted(out->r[i], out->g[i], out->b[i]) * response(direction));
    }
    EXPECT_TRUE(
        AgreesWith(moments.mean(), moments.standard_error(), exact, SidakLevel(3), 1e-3 * exact))
        << specification;
  }
}

// Clusters of samples are as many as asked for, or as far apart.
TEST(StrategySamples, LightsAreMergedAsAsked) {
  const EnvironmentMap map = {AdversarialMap("Noise"), Orientations()[1].map_from_world, {}};
  for (const char* const source : {"median-cut", "variance-cut", "penrose", "polyomino"}) {
    for (const char* const frequency : {"F1", "F2", "F3"}) {
      SCOPED_TRACE(std::string(source) + " " + frequency);
      const std::string merged = std::string(source) + ":lights=60,cluster=" + frequency;
      EXPECT_EQ(MakeStrategy(merged + ",clusters=10", map)->Plan(1).fixed, 10u);
      const auto apart = MakeStrategy(merged + ",separation=40,position=sample", map);
      const std::uint32_t count = apart->Plan(1).fixed;
      EXPECT_GT(count, 4u);
      EXPECT_LT(count, 40u);
      std::vector<Vec> directions;
      for (std::uint32_t index = 0; index < count; ++index) {
        soa::Table<LightColumns> out(1);
        const auto surfaces = SurfacesWith(kNormal, 1);
        apart->Sample(LambertPoints(surfaces, 1), RandomUniforms(1, 1), 1, {.index = index}, out);
        directions.push_back(Get(0, out->dir_x, out->dir_y, out->dir_z));
        for (std::uint32_t other = 0; other < index; ++other) {
          ASSERT_GT(Angle(directions[other], directions[index]) * 180 / kPi, 40 - 1e-3);
        }
      }
    }
  }
}

}  // namespace
}  // namespace skywave
