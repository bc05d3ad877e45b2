// Tests the tiling of trominoes, the squares of the sphere that it fills, and the samples that it
// gives of a map.

#include "lights/light_sets/polyomino.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "base/error.h"
#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/sphere_spectrum.h"
#include "lights/light_sets/tromino_tiling.h"
#include "lights/maps/healpix.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Healpix, SquaresHaveEqualAreasAndABoundedStretch) {
  constexpr double kStep = 1e-5;
  double most = 0;
  for (int square = 0; square < kHealpixSquares; ++square) {
    for (double x = 0.005; x < 1; x += 0.01) {
      for (double y = 0.005; y < 1; y += 0.01) {
        const Vector3 here = DirectionOfHealpix(square, x, y);
        ASSERT_NEAR(Length(here), 1, 1e-12);
        const Vector3 across = (1 / kStep) * (DirectionOfHealpix(square, x + kStep / 2, y) -
                                              DirectionOfHealpix(square, x - kStep / 2, y));
        const Vector3 down = (1 / kStep) * (DirectionOfHealpix(square, x, y + kStep / 2) -
                                            DirectionOfHealpix(square, x, y - kStep / 2));
        // No step is on a crease, where the derivative has two values.
        const double row = square / 4 + 2 - x - y;
        if (std::abs(row - 1) > 0.01 && std::abs(row - 3) > 0.01) {
          ASSERT_NEAR(Length(Cross(across, down)), kPi / 3, 1e-4) << square << " " << x << " " << y;
        }
        for (double turn = 0; turn < kPi; turn += 0.1) {
          most = std::max(most, Length(std::cos(turn) * across + std::sin(turn) * down));
        }
      }
    }
  }
  EXPECT_LE(most, kHealpixStretch);
  EXPECT_GE(most, 0.98 * kHealpixStretch);
}

TEST(Healpix, SquaresCoverTheSphereOnce) {
  // Together with the areas: every direction is near a point of a square, and all moments are
  // those of the sphere.
  constexpr int kSide = 64;
  std::vector<Vector3> points;
  Vector3 first;
  double up = 0, right = 0, crossed = 0;
  for (int square = 0; square < kHealpixSquares; ++square) {
    for (int i = 0; i < kSide * kSide; ++i) {
      points.push_back(
          DirectionOfHealpix(square, (i % kSide + 0.5) / kSide, (i / kSide + 0.5) / kSide));
      const Vector3& p = points.back();
      first += p;
      up += p.z * p.z, right += p.x * p.x, crossed += p.x * p.y;
    }
  }
  const double count = double(points.size());
  EXPECT_NEAR(Length(first) / count, 0, 1e-4);
  EXPECT_NEAR(up / count, 1.0 / 3, 1e-4);
  EXPECT_NEAR(right / count, 1.0 / 3, 1e-4);
  EXPECT_NEAR(crossed / count, 0, 1e-4);
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    const Vector3 direction = test::RandomDirection(random);
    double nearest = 10;
    for (const Vector3& p : points) nearest = std::min(nearest, Length(p - direction));
    EXPECT_LT(nearest, kHealpixStretch / kSide);
  }
}

// Returns the squares of sixths of the parent's box that a child covers.
std::set<std::pair<int, int>> SquaresOf(const TrominoDivision::Child& child) {
  std::set<std::pair<int, int>> squares;
  for (const Complex corner : {Complex{0.5, 0.5}, Complex{1.5, 0.5}, Complex{0.5, 1.5}}) {
    const Complex middle = child.origin + child.axis * corner;
    squares.insert({int(std::floor(3 * middle.re)), int(std::floor(3 * middle.im))});
  }
  return squares;
}

TEST(Trominoes, ChildrenFillTheirParentInManyWays) {
  for (const bool square : {true, false}) {
    EXPECT_EQ(DivisionCount(square), square ? 162u : 4u);
    std::set<std::set<std::set<std::pair<int, int>>>> different;
    for (std::size_t i = 0; i < DivisionCount(square); ++i) {
      const TrominoDivision& division = Division(square, i);
      std::set<std::pair<int, int>> covered;
      std::set<std::set<std::pair<int, int>>> tiles;
      for (const TrominoDivision::Child& child : division.children) {
        const auto squares = SquaresOf(child);
        tiles.insert(squares);
        for (const auto& [x, y] : squares) {
          EXPECT_TRUE(x >= 0 && x < 6 && y >= 0 && y < 6 && (square || x < 3 || y < 3));
          EXPECT_TRUE(covered.insert({x, y}).second) << "covered twice";
        }
      }
      EXPECT_EQ(covered.size(), square ? 36u : 27u);
      EXPECT_TRUE(different.insert(tiles).second) << "found twice";
      ASSERT_EQ(division.samples.size(), division.children.size());
      for (std::size_t m = 1; m <= division.samples.size(); ++m) {
        EXPECT_EQ(division.samples[m - 1].size(), m);
      }
    }
  }
}

// Calls visit(parent, rank, tile) for all tiles of a level; squares are their own parents.
template <class Visit>
void ForEachTile(int level, const Visit& visit) {
  struct Born {
    TrominoTile parent, tile;
    int rank;
  };
  std::vector<Born> tiles;
  for (int rank = 0; rank < kHealpixSquares; ++rank) {
    const TrominoTile square = TrominoSquare(3, rank);
    tiles.push_back({square, square, 0});
  }
  for (int n = 0; n < level; ++n) {
    std::vector<Born> next;
    for (const Born& born : tiles) {
      for (int rank = 0; rank < int(DivisionOf(born.tile).children.size()); ++rank) {
        next.push_back({born.tile, ChildOf(born.tile, rank), rank});
      }
    }
    tiles = std::move(next);
  }
  for (const Born& born : tiles) visit(born.parent, born.rank, born.tile);
}

TEST(Trominoes, ValuesCountTheTilesOfALevel) {
  for (int level = 0; level <= 3; ++level) {
    std::set<std::uint64_t> values;
    ForEachTile(level, [&](const TrominoTile&, int, const TrominoTile& tile) {
      values.insert(tile.value);
    });
    EXPECT_EQ(values.size(), TrominoTiles(level));
    EXPECT_EQ(*values.rbegin(), TrominoTiles(level) - 1);
  }
}

TEST(Trominoes, SamplesMoveLittleAndStayApart) {
  for (const double density : {144.0, 200.0, 500.0, 700.0, 1296.0, 1297.0, 3000.0}) {
    std::vector<Vector3> samples;
    ForEachTile(3, [&](const TrominoTile& parent, int rank, const TrominoTile& tile) {
      if (!(double(tile.value) + 0.5 <= density)) return;
      // Samples of earlier levels are found again from their last tile.
      const Complex place = SampleOf(parent, rank, density);
      EXPECT_TRUE(place.re > 0 && place.re < 1 && place.im > 0 && place.im < 1);
      samples.push_back(DirectionOfHealpix(tile.square, place.re, place.im));
    });
    EXPECT_EQ(double(samples.size()), density);
    const double hexagonal = std::sqrt(4 * kPi / density * 2 / std::sqrt(3.0));
    double sum = 0, least = 10;
    for (const Vector3& a : samples) {
      double nearest = 10;
      for (const Vector3& b : samples) {
        if (&a != &b) nearest = std::min(nearest, Length(a - b));
      }
      sum += nearest / hexagonal / density;
      least = std::min(least, nearest / hexagonal);
    }
    EXPECT_GT(sum, 0.6) << density;
    EXPECT_GT(least, 0.2) << density;
  }
}

TEST(Polyomino, CountIsExact) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    SCOPED_TRACE(name);
    const SphereMap map = MakeSphereMap(image);
    for (const int count : {1, 2, 3, 7, 64, 100, 1000}) {
      const std::vector<PolyominoSample> samples = PolyominoSamples(map, count, 5);
      EXPECT_EQ(int(samples.size()), map.energy > 0 ? count : 0);
      std::set<std::uint64_t> values;
      for (const PolyominoSample& s : samples) {
        ASSERT_NEAR(Length(s.direction), 1, 1e-12);
        ASSERT_GE(s.density * (1 + 1e-12), double(s.value) + 0.5);
        EXPECT_TRUE(values.insert(s.value).second) << "taken twice";
      }
    }
  }
  EXPECT_THROW(PolyominoSamples(MakeSphereMap(Image(2, 1)), 0), InputError);
}

// Whoever places the lights, they carry the light of the map, whatever their number.
TEST(Polyomino, LightsKeepTheEnergyOfTheMap) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    SCOPED_TRACE(name);
    const SphereMap map = MakeSphereMap(image);
    for (const int count : {1, 7, 100, 1000}) {
      const LightSet set = BuildLights(map, {.source = LightSource::kPolyomino, .lights = count});
      double energy = 0;
      for (const DirectionalLight& light : set.lights) energy += light.energy;
      EXPECT_NEAR(energy, map.energy, 1e-12 * map.energy);
      EXPECT_LE(int(set.lights.size()), count);
    }
  }
}

TEST(Polyomino, FindsExactlyTheSamplesOfAFullTiling) {
  const Image image = test::SunMap(64, 32, 300);
  const SphereMap map = MakeSphereMap(image);
  std::set<std::uint64_t> found;
  const std::vector<PolyominoSample> samples = PolyominoSamples(map, 300, 3);
  for (const PolyominoSample& s : samples) found.insert(s.value);
  // The least mag that takes each sample; it lies in the middle of the first tile that it had.
  std::map<std::uint64_t, double> needed;
  for (int level = 4; level >= 0; --level) {
    ForEachTile(level, [&](const TrominoTile&, int, const TrominoTile& tile) {
      const Complex middle = CentreOf(tile);
      double u, v;
      UvOfDirection(DirectionOfHealpix(tile.square, middle.re, middle.im), u, v);
      const int x = std::clamp(int(u * 64), 0, 63), y = std::clamp(int(v * 32), 0, 31);
      needed[tile.value] = (double(tile.value) + 0.5) / map.luminance[std::size_t(y * 64 + x)];
    });
  }
  std::vector<std::pair<double, std::uint64_t>> order;
  for (const auto& [value, least] : needed) order.push_back({least, value});
  std::sort(order.begin(), order.end());
  std::set<std::uint64_t> expected;
  for (std::size_t i = 0; i < samples.size(); ++i) expected.insert(order[i].second);
  EXPECT_EQ(found, expected);
  EXPECT_GT(*expected.rbegin(), 2 * samples.size());  // the sun takes samples of deep levels
}

TEST(Polyomino, PrefixesAreTheSmallerSetsAndSeedsGiveOthers) {
  const Image image = test::SunMap(128, 64, 100);
  const SphereMap map = MakeSphereMap(image);
  const auto large = PolyominoSamples(map, 500), small = PolyominoSamples(map, 200);
  const auto other = PolyominoSamples(map, 500, 2);
  int same = 0;
  for (std::size_t i = 0; i < small.size(); ++i) {
    EXPECT_EQ(large[i].value, small[i].value);
    same += large[i].direction == other[i].direction;
  }
  EXPECT_LT(same, 50);
}

TEST(Polyomino, ATinySunGetsItsShare) {
  constexpr int kWidth = 1024, kHeight = 512, kCount = 256;
  for (const double share : {0.1, 0.6}) {
    for (const int y0 : {3, 170, 508}) {
      Image image = test::ConstantMap(kWidth, kHeight, 1);
      const SphereMap sky = MakeSphereMap(image);
      const float sun = float(sky.energy / sky.solid_angle[y0] * share / (1 - share) / 4);
      double direction_u = 0, direction_v = 0;
      for (int i = 0; i < 4; ++i) {
        float* rgb = image.Pixel(1022 + i % 2, y0 + i / 2);
        rgb[0] = rgb[1] = rgb[2] = sun;
      }
      const SphereMap map = MakeSphereMap(image);
      int in_sun = 0;
      for (const PolyominoSample& s : PolyominoSamples(map, kCount)) {
        UvOfDirection(s.direction, direction_u, direction_v);
        in_sun += direction_u * kWidth >= 1021 && std::abs(direction_v * kHeight - y0 - 1) < 2;
      }
      const double energy = 2 * sun * (map.solid_angle[y0] + map.solid_angle[y0 + 1]);
      const double expected = energy / map.energy * kCount;
      EXPECT_NEAR(in_sun, expected, 6 + 0.05 * expected) << share << ", row " << y0;
    }
  }
}

// Blue noise is more even than Poisson noise, so chi-square stays well below its degrees of
// freedom.
TEST(Polyomino, DensityIsProportionalToLuminance) {
  constexpr int kWidth = 256, kHeight = 128, kGridX = 12, kGridY = 8, kCount = 8000;
  for (const Image& image :
       {test::ConstantMap(kWidth, kHeight, 1), test::SunMap(kWidth, kHeight, 1)}) {
    const SphereMap map = MakeSphereMap(image);
    double expected[kGridY][kGridX] = {}, found[kGridY][kGridX] = {};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        expected[y * kGridY / kHeight][x * kGridX / kWidth] +=
            kCount * map.Energy(x, y) / map.energy;
      }
    }
    for (const PolyominoSample& s : PolyominoSamples(map, kCount, 3)) {
      double u, v;
      UvOfDirection(s.direction, u, v);
      ++found[std::min(int(v * kGridY), kGridY - 1)][std::min(int(u * kGridX), kGridX - 1)];
    }
    double chi2 = 0;
    for (int y = 0; y < kGridY; ++y) {
      for (int x = 0; x < kGridX; ++x) {
        ASSERT_GT(expected[y][x], 5);
        chi2 += std::pow(found[y][x] - expected[y][x], 2) / expected[y][x];
      }
    }
    EXPECT_LT(chi2 / (kGridX * kGridY), 0.5);
  }
}

struct Spectrum {
  double low = 0, largest = 0;  // mean power below half of the principal degree, and of any to it
};

Spectrum SpectrumOf(const std::vector<Vector3>& directions) {
  const double principal = 1.07 * std::sqrt(kPi * double(directions.size()));
  const std::vector<double> power = SpherePower(directions, int(principal));
  Spectrum spectrum;
  for (int l = 1; l < int(power.size()); ++l) {
    if (l < principal / 2) spectrum.low += power[std::size_t(l)] / std::floor(principal / 2);
    spectrum.largest = std::max(spectrum.largest, power[std::size_t(l)]);
  }
  return spectrum;
}

TEST(SphereSpectrum, IsThatOfTheHarmonics) {
  // Of two opposite directions even degrees have power 2, odd ones 0.
  const std::vector<Vector3> opposite = {{0, 0.6, 0.8}, {0, -0.6, -0.8}};
  const std::vector<double> power = SpherePower(opposite, 6);
  for (int l = 0; l <= 6; ++l) EXPECT_NEAR(power[std::size_t(l)], l % 2 == 0 ? 2 : 0, 1e-12);
}

TEST(Polyomino, SpectrumIsBlueOnTheSphere) {
  constexpr int kPatterns = 4;
  const Image image = test::ConstantMap(64, 32, 1);
  const SphereMap map = MakeSphereMap(image);
  for (const int count : {60, 200, 500}) {
    Spectrum blue, white, grid, even_grid;
    std::mt19937 random(1);
    for (int i = 0; i < kPatterns; ++i) {
      const int n = count + count * i / kPatterns;
      const Spectrum of_samples = SpectrumOf(Directions(PolyominoSamples(map, n, 1 + i)));
      blue.low += of_samples.low / kPatterns;
      blue.largest += of_samples.largest / kPatterns;
      std::vector<Vector3> directions;
      for (int k = 0; k < n; ++k) directions.push_back(test::RandomDirection(random));
      white.low += SpectrumOf(directions).low / kPatterns;
      white.largest += SpectrumOf(directions).largest / kPatterns;
      // A grid of equal angles crowds about the poles; one of equal areas is even but regular.
      directions.clear();
      const int rows = int(std::lround(std::sqrt(n / 2.0)));
      for (int k = 0; k < 2 * rows * rows; ++k) {
        directions.push_back(
            DirectionOfUv((k % (2 * rows) + 0.5) / (2 * rows), (k / (2 * rows) + 0.5) / rows));
      }
      grid.low += SpectrumOf(directions).low / kPatterns;
      directions.clear();
      const int side = int(std::lround(std::sqrt(n / 12.0)));
      for (int k = 0; k < kHealpixSquares * side * side; ++k) {
        directions.push_back(DirectionOfHealpix(k / (side * side), (k % side + 0.5) / side,
                                                (k / side % side + 0.5) / side));
      }
      even_grid.largest += SpectrumOf(directions).largest / kPatterns;
    }
    std::printf("%d: power below half of the principal degree: %.4f, white %.3f, grid %.3f\n",
                count, blue.low, white.low, grid.low);
    std::printf("largest power: %.2f, white %.2f, even grid %.2f\n", blue.largest, white.largest,
                even_grid.largest);
    EXPECT_LT(blue.low, 0.1) << count;
    EXPECT_NEAR(white.low, 1, 0.2);
    EXPECT_GT(grid.low, 0.5);
    EXPECT_LT(blue.largest, 6) << count;  // there are no peaks as of a grid
    EXPECT_GT(even_grid.largest, 8) << count;
  }
}

}  // namespace
}  // namespace skywave
