// Compares pairwise clustering with a search over all pairs at every step.

#include "lights/light_sets/clustering.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "base/error.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

struct Plain {
  std::vector<Vector3> centre;
  std::vector<double> frequency;
};

double LeastAngle(const std::vector<Vector3>& directions) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < directions.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      least = std::min(least, AngleBetween(directions[i], directions[j]));
    }
  }
  return least;
}

Plain BruteForce(std::vector<Vector3> c, std::vector<double> f, const ClusterStop& stop) {
  const auto more = [&] {
    return c.size() > 1 && ((stop.clusters > 0 && c.size() > std::size_t(stop.clusters)) ||
                            LeastAngle(c) < stop.separation);
  };
  while (more()) {
    std::size_t a = 0, b = 1;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < c.size(); ++i) {
      for (std::size_t j = i + 1; j < c.size(); ++j) {
        const double angle = AngleBetween(c[i], c[j]);
        const double error = f[i] * f[j] / (f[i] + f[j]) * angle * angle;
        if (error < best) best = error, a = i, b = j;
      }
    }
    const double sum = f[a] + f[b];
    c[a] = NormalizeOr((f[a] / sum) * c[a] + (f[b] / sum) * c[b], 1, c[a]);
    f[a] = sum;
    c.erase(c.begin() + std::ptrdiff_t(b));
    f.erase(f.begin() + std::ptrdiff_t(b));
  }
  return {c, f};
}

// The samples form clouds, so that there is something to merge.
std::vector<Vector3> Samples(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vector3> samples;
  Vector3 centre;
  for (int i = 0; i < count; ++i) {
    if (i % 10 == 0) centre = test::RandomDirection(random);
    const Vector3 away = {normal(random), normal(random), normal(random)};
    samples.push_back(NormalizeOr(centre + 0.03 * away, 1, centre));
  }
  return samples;
}

std::vector<double> Weights(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<double> weights;
  for (int i = 0; i < count; ++i) weights.push_back(std::exp(6.0 * random() / 4294967296.0));
  return weights;
}

void ExpectSame(const Clustering& clusters, const Plain& expected) {
  ASSERT_EQ(clusters.directions.size(), expected.centre.size());
  for (std::size_t i = 0; i < expected.centre.size(); ++i) {
    EXPECT_LT(AngleBetween(clusters.directions[i], expected.centre[i]), 1e-9);
    EXPECT_NEAR(clusters.frequencies[i], expected.frequency[i], 1e-9 * expected.frequency[i]);
  }
}

TEST(Clustering, EqualsBruteForceForBothStops) {
  for (unsigned seed : {1u, 2u, 3u}) {
    const auto samples = Samples(90, seed);
    for (const auto& frequency : {std::vector<double>(90, 1.0), Weights(90, seed)}) {
      for (const ClusterStop& stop :
           {ClusterStop{.clusters = 1}, ClusterStop{.clusters = 13}, ClusterStop{.clusters = 80},
            ClusterStop{.separation = 0.02}, ClusterStop{.separation = 0.3},
            ClusterStop{.clusters = 30, .separation = 0.05}}) {
        ExpectSame(ClusterPairwise(samples, frequency, stop), BruteForce(samples, frequency, stop));
      }
    }
  }
}

TEST(Clustering, MembersMakeTheirClusters) {
  const auto samples = Samples(200, 7);
  const auto weights = Weights(200, 7);
  const Clustering clusters = ClusterPairwise(samples, weights, {.clusters = 40});
  ASSERT_EQ(clusters.directions.size(), 40u);
  std::vector<double> sum(40);
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    const std::uint32_t cluster = clusters.cluster_of_sample[i];
    ASSERT_LE(cluster, next);  // clusters are numbered by their first sample
    if (cluster == next) ++next;
    sum[cluster] += weights[i];
  }
  EXPECT_EQ(next, 40u);
  for (int i = 0; i < 40; ++i) EXPECT_NEAR(sum[i], clusters.frequencies[i], 1e-9 * sum[i]);
}

TEST(Clustering, SeparationHoldsForAllPairs) {
  const auto samples = Samples(300, 9);
  for (double degrees : {1.0, 5.0, 30.0}) {
    const double separation = degrees * std::numbers::pi / 180;
    const Clustering clusters =
        ClusterPairwise(samples, std::vector<double>(300, 1), {.separation = separation});
    EXPECT_GE(LeastAngle(clusters.directions), separation - 1e-12);
    EXPECT_GT(clusters.directions.size(), 1u);
  }
}

TEST(Clustering, FrequenciesDecideWhoMerges) {
  // The samples are a close bright pair and a distant dim pair.
  const std::vector<Vector3> samples = {DirectionOfUv(0.5, 0.5), DirectionOfUv(0.51, 0.5),
                                        DirectionOfUv(0.1, 0.5), DirectionOfUv(0.15, 0.5)};
  const std::vector<CellSums> cells = {
      {.energy = 1000, .energy_moment = {}, .solid_angle = 10, .area_moment = {}},
      {.energy = 1000, .energy_moment = {}, .solid_angle = 10, .area_moment = {}},
      {.energy = 1, .energy_moment = {}, .solid_angle = 1e-3, .area_moment = {}},
      {.energy = 1, .energy_moment = {}, .solid_angle = 1e-3, .area_moment = {}}};
  const auto merged = [&](ClusterFrequency frequency) {
    const auto c = ClusterPairwise(samples, Frequencies(cells, frequency), {.clusters = 3});
    return c.cluster_of_sample[0] == c.cluster_of_sample[1] ? "close" : "dim";
  };
  EXPECT_STREQ(merged(ClusterFrequency::kOne), "close");
  EXPECT_STREQ(merged(ClusterFrequency::kEnergy), "dim");
  EXPECT_STREQ(merged(ClusterFrequency::kMeanLuminance), "close");
}

TEST(Clustering, DegenerateSets) {
  EXPECT_TRUE(ClusterPairwise({}, {}, {.clusters = 3}).directions.empty());
  const Vector3 up = {0, 0, 1}, down = {0, 0, -1};
  const std::vector<double> ones = {1, 1, 1};
  const auto same = ClusterPairwise(std::vector{up, up, up}, ones, {.separation = 1e-6});
  ASSERT_EQ(same.directions.size(), 1u);
  EXPECT_EQ(same.directions[0], up);
  const std::vector<double> uneven = {1, 3};
  const auto opposite =
      ClusterPairwise(std::vector{up, down}, std::vector<double>{1, 1}, {.clusters = 1});
  EXPECT_EQ(opposite.directions[0], up);
  const auto heavier = ClusterPairwise(std::vector{up, down}, uneven, {.clusters = 1});
  EXPECT_EQ(heavier.directions[0], down);
  const auto dark =
      ClusterPairwise(std::vector{up, down, up}, std::vector<double>{0, 0, 0}, {.clusters = 2});
  EXPECT_EQ(dark.directions.size(), 2u);
  const auto few = ClusterPairwise(std::vector{up, down}, uneven, {.clusters = 10});
  EXPECT_EQ(few.directions.size(), 2u);
  EXPECT_EQ(ClusterPairwise(std::vector{up, up}, uneven, {}).directions.size(), 2u);
  EXPECT_EQ(ClusterPairwise(std::vector{up, down}, uneven, {.separation = 10}).directions.size(),
            1u);
}

TEST(Clustering, SamplesWithoutEnergyJoinTheirNearest) {
  const std::vector<Vector3> samples = {DirectionOfUv(0.2, 0.5), DirectionOfUv(0.6, 0.5),
                                        DirectionOfUv(0.58, 0.5), DirectionOfUv(0.22, 0.5),
                                        DirectionOfUv(0.21, 0.5)};
  const auto c = ClusterPairwise(samples, std::vector<double>{5, 1e-3, 0, 0, 0}, {.clusters = 2});
  EXPECT_EQ(c.cluster_of_sample, (std::vector<std::uint32_t>{0, 1, 1, 0, 0}));
  EXPECT_EQ(c.frequencies, (std::vector<double>{5, 1e-3}));
  EXPECT_LT(AngleBetween(c.directions[1], samples[1]), 1e-6);
}

TEST(Clustering, RefusesBadParameters) {
  const std::vector<Vector3> samples = {{0, 0, 1}, {0, 1, 0}};
  const std::vector<double> ones = {1, 1};
  EXPECT_THROW(ClusterPairwise(samples, ones, {.clusters = -1}), InputError);
  EXPECT_THROW(ClusterPairwise(samples, ones, {.separation = -0.1}), InputError);
  EXPECT_THROW(ClusterPairwise(samples, ones, {.separation = NAN}), InputError);
  EXPECT_THROW(ClusterPairwise(samples, std::vector<double>{1, NAN}, {}), InputError);
  EXPECT_THROW(ClusterPairwise(samples, std::vector<double>{1, -1}, {}), InputError);
}

}  // namespace
}  // namespace skywave
