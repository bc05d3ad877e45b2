// Compares Voronoi cells with a search over all samples at every texel.

#include "lights/light_sets/voronoi.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

CellMap BruteForce(int width, int height, const std::vector<Vector3>& samples) {
  const Image image(width, height);
  const SphereMap map = MakeSphereMap(image);
  CellMap cells;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vector3 texel = map.TexelCentre(x, y);
      std::uint32_t owner = kNoCell;
      double best = -2;
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const double dot = Dot(samples[i], texel);
        if (dot > best) best = dot, owner = std::uint32_t(i);
      }
      cells.push_back(owner);
    }
  }
  return cells;
}

void ExpectBruteForce(int width, int height, const std::vector<Vector3>& samples) {
  const CellMap cells = VoronoiCells(width, height, samples);
  const CellMap expected = BruteForce(width, height, samples);
  ASSERT_EQ(cells.size(), expected.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) different += cells[i] != expected[i];
  EXPECT_EQ(different, 0u) << samples.size() << " samples on " << width << " x " << height;
}

TEST(Voronoi, EqualsBruteForceOnRandomSamples) {
  std::mt19937 random(1);
  for (int count : {1, 2, 3, 4, 5, 10, 100, 1000, 3000}) {
    std::vector<Vector3> samples;
    for (int i = 0; i < count; ++i) samples.push_back(test::RandomDirection(random));
    ExpectBruteForce(256, 128, samples);
    ExpectBruteForce(97, 41, samples);
    ExpectBruteForce(3, 2, samples);
    ExpectBruteForce(1, 1, samples);
    ExpectBruteForce(1, 33, samples);
    ExpectBruteForce(300, 5, samples);
  }
}

TEST(Voronoi, EqualsBruteForceOnClusters) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (double spread : {1e-1, 1e-3, 1e-6, 1e-9, 1e-13}) {
    std::vector<Vector3> samples;
    for (int cluster = 0; cluster < 5; ++cluster) {
      const Vector3 centre = test::RandomDirection(random);
      for (int i = 0; i < 60; ++i) {
        const Vector3 away = {normal(random), normal(random), normal(random)};
        samples.push_back(NormalizeOr(centre + spread * away, 1, centre));
      }
    }
    for (int i = 0; i < 20; ++i) samples.push_back(test::RandomDirection(random));
    ExpectBruteForce(128, 64, samples);
  }
}

TEST(Voronoi, EqualsBruteForceOnDegenerateSets) {
  std::mt19937 random(3);
  const Vector3 a = test::RandomDirection(random), b = test::RandomDirection(random);
  ExpectBruteForce(64, 32, {a, a});
  ExpectBruteForce(64, 32, {b, a, b, a, b});
  ExpectBruteForce(64, 32, {a, -1.0 * a});
  ExpectBruteForce(64, 32, std::vector<Vector3>(100, a));
  std::vector<Vector3> equator, circle, hemisphere, axes, rays;
  for (int i = 0; i < 24; ++i) {
    equator.push_back(DirectionOfUv(i / 24.0, 0.5));
    circle.push_back(DirectionOfUv(i / 24.0, 0.1));
    rays.push_back(DirectionOfUv(0.25, i / 23.0));
  }
  ExpectBruteForce(64, 32, equator);
  ExpectBruteForce(64, 32, circle);
  ExpectBruteForce(64, 32, rays);
  for (int i = 0; i < 200; ++i) {
    Vector3 d = test::RandomDirection(random);
    d.z = std::abs(d.z);
    hemisphere.push_back(d);
  }
  ExpectBruteForce(128, 64, hemisphere);
  for (double sign : {1.0, -1.0}) {  // gives ties along whole rows and columns of texels
    axes.push_back({sign, 0, 0});
    axes.push_back({0, sign, 0});
    axes.push_back({0, 0, sign});
  }
  ExpectBruteForce(64, 32, axes);
  ExpectBruteForce(65, 33, axes);
}

TEST(Voronoi, EqualsBruteForceAtSeamAndPoles) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform;
  std::vector<Vector3> seam, poles, texels;
  for (int i = 0; i < 100; ++i) {
    seam.push_back(DirectionOfUv(0.98 + 0.04 * uniform(random), uniform(random)));
    poles.push_back(DirectionOfUv(uniform(random), 0.02 * uniform(random) + i % 2 * 0.98));
    texels.push_back(DirectionOfUv((random() % 64 + 0.5) / 64, (random() % 32 + 0.5) / 32));
  }
  poles.push_back({0, 0, 1});
  poles.push_back({0, 0, -1});
  seam.push_back(DirectionOfUv(0, 0.5));
  for (const auto& samples : {seam, poles, texels}) {
    ExpectBruteForce(64, 32, samples);
    ExpectBruteForce(255, 127, samples);
  }
}

TEST(Voronoi, TilesOfLargeMapsAgreeWithBruteForce) {
  std::mt19937 random(5);
  std::vector<Vector3> samples;
  for (int i = 0; i < 300; ++i) samples.push_back(test::RandomDirection(random));
  ExpectBruteForce(1024, 512, samples);
}

TEST(Voronoi, NoSamplesNoCells) {
  for (std::uint32_t cell : VoronoiCells(8, 4, {})) EXPECT_EQ(cell, kNoCell);
}

}  // namespace
}  // namespace skywave
