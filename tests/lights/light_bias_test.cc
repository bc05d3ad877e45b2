// Tests the number of lights that is chosen for a wanted bias, against sums of its own.

#include "lights/light_sets/light_bias.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "base/error.h"
#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/strata.h"
#include "lights/strategies/strategy.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

// The light of a map beside walls, by the midpoints of parts of its texels.
class Walls {
 public:
  explicit Walls(const Image& image) {
    constexpr int kParts = 4, kPairs = 1500;
    std::vector<std::pair<Vector3, double>> points;
    const int width = image.width * kParts, height = image.height * kParts;
    for (int y = 0; y < height; ++y) {
      const double top = std::cos(std::numbers::pi * y / height);
      const double bottom = std::cos(std::numbers::pi * (y + 1) / height);
      for (int x = 0; x < width; ++x) {
        const double luminance = Luminance(image.Pixel(x / kParts, y / kParts));
        points.push_back({DirectionOfUv((x + 0.5) / width, (y + 0.5) / height),
                          luminance * (top - bottom) * 2 * std::numbers::pi / width});
      }
    }
    std::mt19937 random(11);
    for (int i = 0; i < kPairs; ++i) {
      Wall wall = {test::RandomDirection(random), test::RandomDirection(random)};
      for (const auto& [direction, energy] : points) {
        wall.irradiance += energy * Arrives(wall, direction);
      }
      mean_ += wall.irradiance / kPairs;
      walls_.push_back(wall);
    }
  }

  double Bias(const LightSet& set) const {
    double squares = 0;
    for (const Wall& wall : walls_) {
      double irradiance = 0;
      for (const DirectionalLight& light : set.lights) {
        irradiance += light.energy * Arrives(wall, light.direction);
      }
      squares += (irradiance - wall.irradiance) * (irradiance - wall.irradiance);
    }
    return std::sqrt(squares / double(walls_.size())) / mean_;
  }

 private:
  struct Wall {
    Vector3 normal, face;
    double irradiance = 0;
  };
  static double Arrives(const Wall& wall, const Vector3& direction) {
    return Dot(direction, wall.face) > 0 ? std::max(Dot(direction, wall.normal), 0.0) : 0;
  }
  std::vector<Wall> walls_;
  double mean_ = 0;
};

TEST(LightBias, TheNumberChosenIsGoodEnoughAndHalfOfItIsNot) {
  for (const Image& image : {test::SunMap(96, 48, 40), test::ConstantMap(96, 48, 0.3f)}) {
    const SphereMap map = MakeSphereMap(image);
    const Walls walls(image);
    for (const LightSource source : {LightSource::kPenrose, LightSource::kPolyomino,
                                     LightSource::kMedianCut, LightSource::kVarianceCut}) {
      for (const double wanted : {0.1, 0.03}) {
        SCOPED_TRACE(std::string(ToString(source)) + " " + std::to_string(wanted));
        const LightSet set = BuildLights(map, {.source = source, .bias = wanted});
        const int count = int(set.lights.size());
        const double bias = walls.Bias(set);
        const double of_half =
            walls.Bias(BuildLights(map, {.source = source, .lights = count / 2}));
        std::printf("%s %.3f: %d lights have %.4f (%.4f), half of them %.4f\n",
                    std::string(ToString(source)).c_str(), wanted, count, set.bias, bias, of_half);
        EXPECT_LE(set.bias, wanted);
        // The root mean square over 1500 other pairs is known to a few percent.
        EXPECT_LE(bias, 1.1 * wanted);
        EXPECT_GT(of_half, 1.1 * wanted);
        EXPECT_EQ(NoteOfLights(set).rfind(std::to_string(count) + " lights", 0), 0u);
      }
    }
  }
}

TEST(LightBias, ALightForEachTexelHasNoBias) {
  // A light for each texel, where its light has its centroid.
  const Image image = test::NoiseMap(256, 128, 3);
  const SphereMap map = MakeSphereMap(image);
  LightSet set;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const Vector3 moment = map.DirectionIntegral(x, y);
      set.lights.push_back(
          {.direction = (1 / Length(moment)) * moment, .energy = map.Energy(x, y)});
    }
  }
  EXPECT_LT(LightBias(map).Of(set.lights), 1e-4);
  // Without light all of it is missing; the mean square of the irradiance is not less than the
  // square of its mean.
  EXPECT_GT(LightBias(map).Of({}), 1);
}

TEST(LightBias, CoarseMapsAreAreasAndNotPoints) {
  const Image fine = test::ConstantMap(128, 64, 2), image = test::ConstantMap(1, 1, 2);
  const SphereMap map = MakeSphereMap(image), fine_map = MakeSphereMap(fine);
  const LightSet set = BuildLights(fine_map, {.source = LightSource::kVarianceCut, .lights = 6});
  const double bias = LightBias(fine_map).Of(set.lights);
  EXPECT_GT(bias, 0.1);
  EXPECT_NEAR(LightBias(map).Of(set.lights), bias, 0.02 * bias);
  // A texel cannot be cut, so that no number is enough for a map of one.
  EXPECT_THROW(BuildLights(map, {.source = LightSource::kVarianceCut, .bias = 0.1}), OptionError);
}

// The bias of a hybrid is that of the light of the whole map, of which lights stand for a part.
TEST(LightBias, LightsOfAHybridAreNoMoreThanTheWholeNeeds) {
  const EnvironmentMap map = {test::SunMap(64, 32, 40), {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  constexpr double kWanted = 0.05;
  const auto strategy =
      MakeStrategy("hybrid:lights=auto:0.05,strata=p,p=0.3,from=variance-cut", map);
  const int count = int(strategy->Plan(1).fixed);
  const SphereMap whole = MakeSphereMap(map.latlong);
  const Strata strata = StrataByFraction(whole, 0.3);
  const Image bright = StratumImage(whole, strata, true);
  const SphereMap part = MakeSphereMap(bright);
  const double share = part.energy / whole.energy;
  EXPECT_LT(share, 0.5);
  const auto bias = [&](int lights) {
    const LightSet set = BuildLights(part, {.source = LightSource::kVarianceCut, .lights = lights});
    return share * LightBias(part).Of(set.lights);
  };
  ASSERT_GT(count, 3);
  EXPECT_LE(bias(count), 1.05 * kWanted);
  EXPECT_GT(bias(count - std::max(1, count / 4)), kWanted);
}

TEST(LightBias, StrategiesTakeItAndSaySo) {
  const EnvironmentMap map = {test::SunMap(64, 32, 40), {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  for (const char* specification :
       {"variance-cut:lights=auto:0.2", "polyomino:lights=auto:0.2", "hybrid:lights=auto:0.2",
        "presampled:lights=auto:0.2,mode=fixed"}) {
    EXPECT_NE(MakeStrategy(specification, map)->note().find("relative bias"), std::string::npos)
        << specification;
  }
  EXPECT_EQ(MakeStrategy("variance-cut:lights=20", map)->note(), "");
  const EnvironmentMap black = {Image(8, 4), {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  EXPECT_EQ(MakeStrategy("variance-cut:lights=auto:0.2", black)->Plan(1).total(), 0u);
  for (const char* specification :
       {"penrose:lights=auto", "penrose:lights=auto:", "penrose:lights=auto:0",
        "penrose:lights=auto:2", "penrose:lights=auto:few", "presampled:lights=auto:0.1",
        "hybrid:lights=auto:0.1,inside=1", "hybrid:lights=auto:0.1,strata=lights"}) {
    EXPECT_THROW(MakeStrategy(specification, map), OptionError) << specification;
  }
}

}  // namespace
}  // namespace skywave
