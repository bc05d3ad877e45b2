// Tests samples that Lloyd's relaxation places: they stand in the centroids of their cells, and
// where they start.
#include "lights/light_sets/relaxed_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "base/error.h"
#include "lights/light_sets/voronoi.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

using Method = std::vector<Vector3> (*)(const SphereMap& map, int count);
std::vector<Vector3> KMeans(const SphereMap& map, int count) { return KMeansSamples(map, count); }
constexpr Method kMethods[] = {KMeans, KolligKellerSamples};

int LitTexels(const SphereMap& map) {
  return int(std::count_if(map.luminance.begin(), map.luminance.end(),
                           [](float luminance) { return luminance > 0; }));
}

// Returns the sum of energy times the square of the distance to the nearest sample.
double Distortion(const SphereMap& map, const std::vector<Vector3>& samples) {
  double sum = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      double nearest = 4;
      for (const Vector3& sample : samples) {
        const Vector3 apart = sample - map.TexelCentre(x, y);
        nearest = std::min(nearest, Dot(apart, apart));
      }
      sum += map.Energy(x, y) * nearest;
    }
  }
  return sum;
}

TEST(RelaxedSamples, AreAsManyAsAskedForWhereThereIsLight) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    SCOPED_TRACE(name);
    const SphereMap map = MakeSphereMap(image);
    for (const int count : {1, 2, 5, 40}) {
      EXPECT_EQ(KMeansSamples(map, count).size(), std::size_t(std::min(count, LitTexels(map))));
      EXPECT_LE(KolligKellerSamples(map, count).size(),
                std::size_t(std::min(count, LitTexels(map))));
    }
  }
  const Image noise = test::NoiseMap(64, 32, 3);
  EXPECT_EQ(KolligKellerSamples(MakeSphereMap(noise), 100).size(), 100u);
}

TEST(RelaxedSamples, StandInTheCentroidsOfTheirCells) {
  const Image image = test::SunMap(64, 32, 50);
  const SphereMap map = MakeSphereMap(image);
  for (const Method method : kMethods) {
    const std::vector<Vector3> samples = method(map, 12);
    const std::vector<Vector3> moved = LloydStep(map, samples);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      EXPECT_LT(AngleBetween(samples[i], moved[i]), 0.02) << "sample " << i;
    }
  }
}

// Two small suns of unequal light, far apart: two samples are the suns.
TEST(RelaxedSamples, TwoOfTwoSunsAreTheSuns) {
  Image image(64, 32);
  for (int c = 0; c < 3; ++c) image.Pixel(10, 12)[c] = 50, image.Pixel(50, 20)[c] = 200;
  const SphereMap map = MakeSphereMap(image);
  for (const Method method : kMethods) {
    std::vector<Vector3> samples = method(map, 2);
    ASSERT_EQ(samples.size(), 2u);
    if (samples[0].z < samples[1].z) std::swap(samples[0], samples[1]);
    const auto middle = [&](int x, int y) {
      return NormalizeOr(map.DirectionIntegral(x, y), 1, Vector3());
    };
    EXPECT_LT(AngleBetween(samples[0], middle(10, 12)), 1e-6);
    EXPECT_LT(AngleBetween(samples[1], middle(50, 20)), 1e-6);
  }
}

// What k-means and its kin make small, by far more than as many samples drawn by energy.
TEST(RelaxedSamples, AreNearerToTheLightThanRandomOnes) {
  const Image image = test::SunMap(64, 32, 300);
  const SphereMap map = MakeSphereMap(image);
  std::mt19937 random(5);
  std::vector<double> energy;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) energy.push_back(map.Energy(x, y));
  }
  std::discrete_distribution<int> draw(energy.begin(), energy.end());
  std::vector<Vector3> drawn;
  for (int i = 0; i < 16; ++i) {
    const int texel = draw(random);
    drawn.push_back(map.TexelCentre(texel % map.width, texel / map.width));
  }
  for (const Method method : kMethods) {
    EXPECT_LT(Distortion(map, method(map, 16)), 0.6 * Distortion(map, drawn));
  }
}

TEST(RelaxedSamples, OtherSeedsOfKMeansStartElsewhere) {
  const Image image = test::SunMap(64, 32, 50);
  const SphereMap map = MakeSphereMap(image);
  EXPECT_EQ(KMeansSamples(map, 9, 1), KMeansSamples(map, 9, 1));
  EXPECT_NE(KMeansSamples(map, 9, 1), KMeansSamples(map, 9, 2));
}

// A sun that moves by two texels of 5.6 degrees, in a sky that stands still.
Image SkyWithSun(int column) {
  Image image = test::ConstantMap(64, 32, 0.1f);
  for (int c = 0; c < 3; ++c) image.Pixel(column, 10)[c] = 500;
  return image;
}

// Returns how far the samples have moved [rad], each from where it was.
std::vector<double> Moves(const std::vector<Vector3>& from, const std::vector<Vector3>& to) {
  std::vector<double> moves;
  for (std::size_t i = 0; i < from.size() && i < to.size(); ++i) {
    moves.push_back(AngleBetween(from[i], to[i]));
  }
  return moves;
}

TEST(RelaxedSamples, ThatFollowMoveWithTheLight) {
  const Image before = SkyWithSun(20), after = SkyWithSun(22);
  const SphereMap map = MakeSphereMap(before), next = MakeSphereMap(after);
  std::vector<Vector3> samples = KMeansSamples(map, 24);
  for (int i = 0; i < 4; ++i) samples = FollowingSamples(map, samples);  // until they stand still
  const std::vector<Vector3> following = FollowingSamples(next, samples);
  ASSERT_EQ(following.size(), samples.size());
  for (const double move : Moves(samples, following)) EXPECT_LT(move, 0.25);
  const std::vector<Vector3> still = FollowingSamples(map, samples);
  for (const double move : Moves(samples, still)) EXPECT_LT(move, 0.02);
  const std::vector<Vector3> moved = LloydStep(next, following);
  for (const double move : Moves(following, moved)) EXPECT_LT(move, 0.02);
  const auto nearest_sun = [&](const std::vector<Vector3>& all) {
    double nearest = 4;
    for (const Vector3& s : all) {
      nearest = std::min(nearest, AngleBetween(s, next.TexelCentre(22, 10)));
    }
    return nearest;
  };
  EXPECT_LT(nearest_sun(following), 0.01);
}

TEST(RelaxedSamples, ThatFollowStartAnewWhereTheirLightIsOut) {
  Image half = test::NoiseMap(64, 32, 3);
  const SphereMap map = MakeSphereMap(half);
  const std::vector<Vector3> samples = KMeansSamples(map, 20);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      for (int c = 0; c < 3; ++c) half.Pixel(x, y)[c] = 0;
    }
  }
  const SphereMap next = MakeSphereMap(half);
  const std::vector<Vector3> following = FollowingSamples(next, samples);
  EXPECT_EQ(following.size(), samples.size());
  EXPECT_EQ(VoronoiLights(next, following, LightPosition::kSample).lights.size(), samples.size());
  const Image black = test::ConstantMap(8, 4, 0);
  EXPECT_TRUE(FollowingSamples(MakeSphereMap(black), samples).empty());
}

TEST(RelaxedSamples, NoLightsAreRefused) {
  const Image image = test::ConstantMap(8, 4, 1);
  const SphereMap map = MakeSphereMap(image);
  for (const Method method : kMethods) EXPECT_THROW(method(map, 0), InputError);
}

}  // namespace
}  // namespace skywave
