// Tests the Penrose tiling against its theorems, and the table of corrections.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "base/error.h"
#include "lights/light_sets/penrose.h"
#include "lights/light_sets/penrose_corrections.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

// Returns all tiles of one level.
std::vector<PlacedTile> Tiling(int level) {
  const auto seed = SeedRhombus({0.3, -0.2}, Polar(1, 17));
  std::vector<PlacedTile> tiles(seed.begin(), seed.end());
  for (int n = 0; n < level; ++n) {
    std::vector<PlacedTile> next;
    for (const PlacedTile& tile : tiles) {
      std::array<PlacedTile, 4> children;
      const int count = Subdivide(tile, children);
      next.insert(next.end(), children.begin(), children.begin() + count);
    }
    tiles = std::move(next);
  }
  return tiles;
}

bool IsSample(const PlacedTile& t) {
  return t.type == PenroseTile::kA || t.type == PenroseTile::kB;
}

double Cross(Complex a, Complex b) { return a.re * b.im - a.im * b.re; }

double Area(const PlacedTile& t) {
  const auto p = Corners(t);
  return Cross(p[1] - p[0], p[2] - p[0]) / 2;
}

bool Contains(const PlacedTile& t, Complex q, double margin = 0) {
  const auto p = Corners(t);
  for (int i = 0; i < 3; ++i) {
    if (Cross(p[(i + 1) % 3] - p[i], q - p[i]) < -margin) return false;
  }
  return true;
}

using Key = std::pair<long, long>;
Key Rounded(Complex p) { return {std::lround(p.re * 1e8), std::lround(p.im * 1e8)}; }

TEST(PenroseTiling, ChildrenFillTheirParent) {
  for (const PlacedTile& parent : Tiling(3)) {
    std::array<PlacedTile, 4> children;
    const int count = Subdivide(parent, children);
    if (IsSample(parent)) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(children[0].value, parent.value);
      EXPECT_EQ(Rounded(children[0].origin), Rounded(parent.origin));
      continue;
    }
    double area = 0;
    for (int i = 0; i < count; ++i) {
      if (IsSample(children[i])) {
        EXPECT_TRUE(Contains(parent, children[i].origin, 1e-12));
        continue;
      }
      EXPECT_GT(Area(children[i]), 0);  // no mirror images
      area += Area(children[i]);
      for (Complex corner : Corners(children[i])) EXPECT_TRUE(Contains(parent, corner, 1e-12));
    }
    EXPECT_NEAR(area, Area(parent), 1e-15);
  }
}

TEST(PenroseTiling, AreaIsConservedAndEveryPointIsInOneTriangle) {
  const auto tiles = Tiling(6);
  double area = 0;
  for (const PlacedTile& t : tiles) area += IsSample(t) ? 0 : Area(t);
  EXPECT_NEAR(area, RhombusArea(1), 1e-12);
  EXPECT_NEAR(RhombusArea(1), 2.489898284883, 1e-12);

  const PlacedTile seed[2] = {SeedRhombus({0.3, -0.2}, Polar(1, 17))[0],
                              SeedRhombus({0.3, -0.2}, Polar(1, 17))[1]};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i < 2000; ++i) {
    const auto p = Corners(seed[i % 2]);
    double s = uniform(random), t = uniform(random);
    if (s + t > 1) s = 1 - s, t = 1 - t;
    const Complex q = p[0] + s * (p[1] - p[0]) + t * (p[2] - p[0]);
    int owners = 0;
    for (const PlacedTile& tile : tiles) owners += !IsSample(tile) && Contains(tile, q);
    EXPECT_EQ(owners, 1);
  }
}

TEST(PenroseTiling, IsEdgeToEdge) {
  std::map<std::pair<Key, Key>, int> edges;
  for (const PlacedTile& t : Tiling(6)) {
    if (IsSample(t)) continue;
    const auto p = Corners(t);
    for (int i = 0; i < 3; ++i) {
      Key a = Rounded(p[i]), b = Rounded(p[(i + 1) % 3]);
      ++edges[{std::min(a, b), std::max(a, b)}];
    }
  }
  // Edges on the border of the rhombus have one triangle, all others have two.
  int border = 0;
  double border_length = 0;
  for (const auto& [edge, triangles] : edges) {
    ASSERT_LE(triangles, 2);
    if (triangles != 1) continue;
    ++border;
    border_length +=
        std::hypot(edge.first.first - edge.second.first, edge.first.second - edge.second.second) *
        1e-8;
  }
  EXPECT_GT(border, 20);
  EXPECT_NEAR(border_length, 4 * kPhi, 1e-5);
}

TEST(PenroseTiling, CountsAreFibonacciAndCodesABijection) {
  for (int level = 1; level <= 9; ++level) {
    const auto tiles = Tiling(level);
    std::array<std::uint64_t, 6> count = {};
    std::set<std::uint64_t> values;
    std::set<Key> places, vertices;
    for (const PlacedTile& t : tiles) {
      ++count[int(t.type)];
      if (IsSample(t)) {
        values.insert(t.value);
        places.insert(Rounded(t.origin));
      } else {
        for (Complex corner : Corners(t)) vertices.insert(Rounded(corner));
      }
    }
    EXPECT_EQ(count[2], Fibonacci(2 * level));
    EXPECT_EQ(count[3], Fibonacci(2 * level));
    EXPECT_EQ(count[4], Fibonacci(2 * level + 1));
    EXPECT_EQ(count[5], Fibonacci(2 * level + 1));
    const std::uint64_t samples = Fibonacci(2 * level + 2) - 1;
    EXPECT_EQ(count[0] + count[1], samples);
    EXPECT_EQ(values.size(), samples);
    EXPECT_EQ(*values.begin(), 1u);
    EXPECT_EQ(*values.rbegin(), samples);
    EXPECT_EQ(places.size(), samples);
    EXPECT_TRUE(std::includes(vertices.begin(), vertices.end(), places.begin(), places.end()));
  }
}

TEST(PenroseTiling, SamplesKeepValueAndPlace) {
  std::map<std::uint64_t, Key> old;
  for (const PlacedTile& t : Tiling(5)) {
    if (IsSample(t)) old[t.value] = Rounded(t.origin);
  }
  std::size_t found = 0;
  for (const PlacedTile& t : Tiling(7)) {
    if (!IsSample(t) || !old.count(t.value)) continue;
    EXPECT_EQ(old[t.value], Rounded(t.origin));
    ++found;
  }
  EXPECT_EQ(found, old.size());
}

// Compares the digits that the production rules add with greedy division.
void CheckCodes(const PlacedTile& tile, std::uint64_t code, int depth) {
  if (IsSample(tile)) {
    if (code == 0) return;
    EXPECT_EQ(code & code << 1, 0u) << "two neighbouring ones";
    std::uint64_t value = 0;
    for (int bit = 0; bit < 2 * tile.level; ++bit) {
      if (code >> bit & 1) value += Fibonacci(bit + 2);
    }
    EXPECT_EQ(value, tile.value);
    const int shift = 2 * tile.level - 6;
    const std::uint64_t leading = shift >= 0 ? code >> shift : code << -shift;
    int expected = 0;
    for (int bit = 0; bit < 6; ++bit) expected += leading >> bit & 1 ? int(Fibonacci(bit + 2)) : 0;
    EXPECT_EQ(StructuralClass(tile.value, tile.level), expected);
  }
  if (depth == 0) return;
  std::array<PlacedTile, 4> children;
  const int count = Subdivide(tile, children);
  for (int i = 0; i < count; ++i) {
    const std::uint64_t added = children[i].value - tile.value;
    const int n = children[i].level;
    ASSERT_TRUE(added == 0 || added == Fibonacci(2 * n + 1) || added == Fibonacci(2 * n));
    std::uint64_t digits = 0;
    if (added == Fibonacci(2 * n + 1)) digits = 2;
    // At level 1 the two new digits weigh F(3) = 2 and F(2) = 1, so the sum distinguishes them.
    if (added == Fibonacci(2 * n)) digits = 1;
    CheckCodes(children[i], code | digits << (2 * n - 2), depth - 1);
  }
}

TEST(PenroseTiling, CodesAreZeckendorfAndGiveTheClasses) {
  for (const PlacedTile& t : SeedRhombus({}, {1, 0})) CheckCodes(t, 0, 8);
  std::map<int, std::set<PenroseTile>> types;
  for (const PlacedTile& t : Tiling(8)) {
    if (IsSample(t)) types[StructuralClass(t.value, 8)].insert(t.type);
  }
  EXPECT_EQ(types.size(), 21u);
  for (const auto& [structural, seen] : types) {
    if (structural == 0) continue;
    EXPECT_EQ(seen.size(), 1u);
    const bool b = structural >= 3 && structural <= 7;
    EXPECT_EQ(*seen.begin(), b ? PenroseTile::kB : PenroseTile::kA) << structural;
  }
}

TEST(PenroseTiling, LevelsOfImportanceAndBirth) {
  for (int x = 1; x < 200000; ++x) {
    const int level = LevelOfImportance(x);
    ASSERT_GE(Fibonacci(2 * level + 2) - 1, std::uint64_t(x));
    ASSERT_LT(Fibonacci(2 * level) - 1, std::uint64_t(x));
    ASSERT_EQ(int(std::ceil(LevelAndPhase(x))) - 1, level);
    ASSERT_EQ(BirthLevel(std::uint64_t(x)), level);
  }
  EXPECT_EQ(LevelOfImportance(0.9), 0);
}

TEST(PenroseTiling, BasesTurnAsTheTilesDo) {
  for (const PlacedTile& born : Tiling(3)) {
    if (!IsSample(born) || BirthLevel(born.value) != 3) continue;
    PlacedTile tile = born;
    for (int level = 4; level < 10; ++level) {
      std::array<PlacedTile, 4> children;
      Subdivide(tile, children);
      tile = children[0];
      const Complex off = BasisAtLevel(born.axis, 3, level) - tile.axis;
      EXPECT_NEAR(std::hypot(off.re, off.im), 0, 1e-12);
    }
  }
}

TEST(PenroseCorrections, AreTheTablesInTheMiddleOfItsRows) {
  const PenroseCorrections& table = DefaultPenroseCorrections();
  for (const std::uint64_t value : {1u, 4u, 30u, 200u}) {
    const int birth = BirthLevel(value);
    const BornSample born = {{}, Polar(1, 30), value, birth};
    for (int level = birth; level < birth + 4; ++level) {
      for (int row = 0; row < kPenroseRows; ++row) {
        const double t = level + (row + 0.5) / kPenroseRows;
        const double x = (std::pow(kPhi * kPhi, t) - 1) / std::sqrt(5.0);
        const Complex expected =
            BasisAtLevel(born.axis, birth, level) * table[row][StructuralClass(value, level)];
        const Complex off = PenroseCorrection(table, born, x) - expected;
        EXPECT_NEAR(std::hypot(off.re, off.im), 0, 1e-9);
      }
    }
  }
}

// Returns for each class how far its samples are from the centroids of their Voronoi cells in the
// mean, in spacings and in the basis of their tiles, where `importance` samples of one level are
// displaced by a table; classes of few samples are left out.
std::map<int, double> LeftToRelax(const PenroseCorrections& table, int level, double importance) {
  constexpr int kPointsPerSpacing = 12, kFewest = 16;
  struct Sample {
    Complex place, basis, sum;
    int structural, points = 0;
    bool inside;
  };
  const double spacing = std::sqrt(RhombusArea(1) / importance);
  // The rhombus that Tiling begins with; at its border cells are cut off.
  const Complex corner = {0.3, -0.2}, turn = Polar(1, 17);
  const Complex sides[2] = {turn * Polar(kPhi, -36), turn * Polar(kPhi, 36)};
  std::vector<Sample> samples;
  for (int birth = 1; birth <= level + 1; ++birth) {
    for (const PlacedTile& t : Tiling(birth)) {
      if (!IsSample(t) || BirthLevel(t.value) != birth || double(t.value) > importance) continue;
      const BornSample born = {t.origin, t.axis, t.value, birth};
      const double area = Cross(sides[0], sides[1]);
      const double a = Cross(t.origin - corner, sides[1]) / area,
                   b = Cross(sides[0], t.origin - corner) / area;
      samples.push_back({t.origin + PenroseCorrection(table, born, importance),
                         BasisAtLevel(t.axis, birth, level),
                         {},
                         StructuralClass(t.value, level),
                         0,
                         std::min({a, b, 1 - a, 1 - b}) > 4 * spacing});
    }
  }
  std::map<Key, std::vector<std::size_t>> buckets;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Complex p = samples[i].place;
    buckets[{std::lround(p.re / spacing), std::lround(p.im / spacing)}].push_back(i);
  }
  // Points of a fine grid belong to the cell of the nearest sample.
  for (const auto& [key, ignored] : buckets) {
    std::vector<std::size_t> near;
    for (long i = 0; i < 25; ++i) {
      const auto found = buckets.find({key.first + i % 5 - 2, key.second + i / 5 - 2});
      if (found == buckets.end()) continue;
      near.insert(near.end(), found->second.begin(), found->second.end());
    }
    for (int i = 0; i < kPointsPerSpacing * kPointsPerSpacing; ++i) {
      const double x = (i % kPointsPerSpacing + 0.5) / kPointsPerSpacing - 0.5;
      const double y = (i / kPointsPerSpacing + 0.5) / kPointsPerSpacing - 0.5;
      const Complex p = {(double(key.first) + x) * spacing, (double(key.second) + y) * spacing};
      const auto distance = [&](std::size_t s) {
        return std::hypot(samples[s].place.re - p.re, samples[s].place.im - p.im);
      };
      const std::size_t nearest = *std::min_element(
          near.begin(), near.end(),
          [&](std::size_t one, std::size_t other) { return distance(one) < distance(other); });
      samples[nearest].sum = samples[nearest].sum + (p - samples[nearest].place);
      ++samples[nearest].points;
    }
  }
  std::map<int, Complex> sums;
  std::map<int, int> counts;
  for (const Sample& sample : samples) {
    if (!sample.inside) continue;
    const Complex off = (1 / (sample.points * spacing)) * sample.sum;
    const Complex back = {sample.basis.re, -sample.basis.im};
    Complex& sum = sums[sample.structural];
    sum = sum + (1 / std::hypot(back.re, back.im)) * (off * back);
    ++counts[sample.structural];
  }
  std::map<int, double> left;
  for (const auto& [structural, sum] : sums) {
    const int count = counts[structural];
    if (count >= kFewest) left[structural] = std::hypot(sum.re, sum.im) / count;
  }
  return left;
}

// One step by the table stands for Lloyd's relaxation to its end. What is left of it in the middle
// of a row comes from the other importances that the row was computed from. The other sign of
// almost any vector leaves more in its class.
TEST(PenroseCorrections, LeaveNothingToRelax) {
  constexpr int kLevel = 8;
  const PenroseCorrections none = {};
  for (int row = 0; row < kPenroseRows; ++row) {
    SCOPED_TRACE(row);
    const double t = kLevel + (row + 0.5) / kPenroseRows;
    const double importance = (std::pow(kPhi * kPhi, t) - 1) / std::sqrt(5.0);
    const auto mean_square = [&](const std::map<int, double>& left) {
      double sum = 0;
      for (const auto& [structural, off] : left) sum += off * off / double(left.size());
      return sum;
    };
    const auto left = LeftToRelax(DefaultPenroseCorrections(), kLevel, importance);
    EXPECT_GT(left.size(), 8u);
    for (const auto& [structural, off] : left) EXPECT_LT(off, 0.045) << structural;
    const double without = mean_square(LeftToRelax(none, kLevel, importance));
    EXPECT_LT(std::sqrt(mean_square(left)), 0.5 * std::sqrt(without));
  }
}

TEST(PenroseCorrections, AreContinuousInImportance) {
  // There is no jump where rows or levels meet, for samples that are old enough on both sides.
  for (const PlacedTile& t : Tiling(4)) {
    if (!IsSample(t)) continue;
    const int birth = BirthLevel(t.value);
    if (birth > 4) continue;
    const BornSample born = {t.origin, BasisAtLevel({1, 0}, 0, birth), t.value, birth};
    double x = 1.2 * double(Fibonacci(2 * birth + 2));
    Complex before = PenroseCorrection(DefaultPenroseCorrections(), born, x);
    while (x < 3e4) {
      x *= 1.002;
      const Complex after = PenroseCorrection(DefaultPenroseCorrections(), born, x);
      ASSERT_LT(std::hypot(after.re - before.re, after.im - before.im), 0.06 / std::sqrt(x)) << x;
      before = after;
    }
  }
}

}  // namespace
}  // namespace skywave
