// Tests the Penrose tiling against its theorems, and the sampler against the given importance.

#include "lights/light_sets/penrose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "base/error.h"
#include "lights/light_sets/penrose_corrections.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

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

TEST(MaxPyramid, BoundsEveryRectangle) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(image));
    std::mt19937 random(1);
    for (int round = 0; round < 300; ++round) {
      const int w = pyramid.width(), h = pyramid.height();
      Region r = {int(random() % (w + 8)) - 4, int(random() % (h + 8)) - 4, 0, 0};
      r.x1 = r.x0 + int(random() % unsigned(w + 4));
      r.y1 = r.y0 + int(random() % unsigned(h + 4));
      float exact = 0;
      for (int y = std::max(r.y0, 0); y < std::min(r.y1, h); ++y) {
        for (int x = std::max(r.x0, 0); x < std::min(r.x1, w); ++x) {
          exact = std::max(exact, pyramid.At(x, y));
        }
      }
      ASSERT_GE(pyramid.Bound(r), exact) << name;
      const int side = std::max({r.x1 - r.x0, r.y1 - r.y0, 1});
      float near = 0;
      for (int y = std::max(r.y0 - side + 1, 0); y < std::min(r.y1 + side - 1, h); ++y) {
        for (int x = std::max(r.x0 - side + 1, 0); x < std::min(r.x1 + side - 1, w); ++x) {
          near = std::max(near, pyramid.At(x, y));
        }
      }
      ASSERT_LE(pyramid.Bound(r), near) << name;
    }
  }
  EXPECT_THROW(MakeMaxPyramid(2, 1, {1, NAN}), InputError);
  EXPECT_THROW(MakeMaxPyramid(2, 1, {1, -1}), InputError);
  EXPECT_THROW(MakeMaxPyramid(0, 0, {}), InputError);
}

TEST(Penrose, FindsExactlyTheSamplesOfAFullTiling) {
  const Image image = test::SunMap(64, 32, 300);
  const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(image));
  const double mag = 400 * PenroseRhombusArea(64, 32, {}) / pyramid.sum;
  const PenroseSet set = PenroseSamplesAtMag(pyramid, mag);
  // Pruning must lose nothing: more importance elsewhere only adds samples elsewhere.
  std::vector<float> raised = pyramid.levels[0].value;
  for (float& value : raised) value = std::max(value, 0.02f * pyramid.maximum());
  const PenroseSet all = PenroseSamplesAtMag(MakeMaxPyramid(64, 32, raised), mag);
  std::set<std::pair<std::uint64_t, std::uint32_t>> found, expected;
  for (const PenroseSample& s : set.samples) found.insert({s.value, s.texel});
  for (const PenroseSample& s : all.samples) {
    if (mag * pyramid.levels[0].value[s.texel] >= double(s.value)) {
      expected.insert({s.value, s.texel});
    }
  }
  EXPECT_EQ(found, expected);
  EXPECT_GT(all.samples.size(), 2 * set.samples.size());
}

TEST(Penrose, ClosedFormMagGivesTheCountWithinTwoPercent) {
  constexpr int kSeeds = 12;
  for (const Image& image :
       {test::ConstantMap(256, 128, 1), test::SunMap(256, 128, 1), test::SunMap(256, 128, 1e4f)}) {
    const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(image));
    for (int count : {256, 1024, 4096}) {
      double mean = 0;
      for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const double area = PenroseRhombusArea(256, 128, {.seed = seed});
        const auto set = PenroseSamplesAtMag(pyramid, count * area / pyramid.sum, {.seed = seed});
        const double found = double(set.samples.size());
        EXPECT_NEAR(found / count, 1, 1.3 / std::sqrt(count)) << count << ", seed " << seed;
        mean += found / kSeeds;
      }
      EXPECT_NEAR(mean / count, 1, 0.02) << count;
    }
  }
}

TEST(Penrose, CountIsExact) {
  for (const auto& [name, image] : test::AdversarialMaps()) {
    SCOPED_TRACE(name);
    const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(image));
    for (int count : {1, 2, 3, 64, 257, 3000}) {
      for (double xi : {0.0, 0.7}) {
        const PenroseSet set = PenroseSamples(pyramid, count, {.seed = 5, .xi = xi});
        EXPECT_EQ(int(set.samples.size()), pyramid.sum > 0 ? count : 0);
        for (const PenroseSample& s : set.samples) {
          ASSERT_TRUE(s.u >= 0 && s.u < 1 && s.v >= 0 && s.v < 1);
          ASSERT_GT(s.importance, 0);
          ASSERT_GE(s.importance * (1 + 1e-12), double(s.value) - xi);
        }
      }
    }
  }
}

TEST(Penrose, PrefixesAreTheSmallerSets) {
  const Image image = test::SunMap(128, 64, 100);
  const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(image));
  const PenroseSet large = PenroseSamples(pyramid, 500), small = PenroseSamples(pyramid, 200);
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(large.samples[i].value, small.samples[i].value);
    EXPECT_EQ(large.samples[i].texel, small.samples[i].texel);
  }
}

TEST(Penrose, ATinySunGetsItsShare) {
  constexpr int kWidth = 1024, kHeight = 512, kCount = 256;
  for (double share : {0.1, 0.3, 0.6}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      Image image = test::ConstantMap(kWidth, kHeight, 1);
      double sky = 0;
      {
        const SphereMap map = MakeSphereMap(image);
        sky = map.energy / map.solid_angle[171];
      }
      const float sun = float(sky * share / (1 - share) / 4);
      const int x0 = int(100 * seed), y0 = 170;
      for (int i = 0; i < 4; ++i) {
        float* rgb = image.Pixel(x0 + i % 2, y0 + i / 2);
        rgb[0] = rgb[1] = rgb[2] = sun;
      }
      const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(image));
      const PenroseSet set = PenroseSamples(pyramid, kCount, {.seed = seed, .xi = 0.5});
      int in_sun = 0;
      for (const PenroseSample& s : set.samples) {
        const int x = int(s.texel % kWidth), y = int(s.texel / kWidth);
        in_sun += x >= x0 && x < x0 + 2 && y >= y0 && y < y0 + 2;
      }
      EXPECT_NEAR(in_sun, share * kCount, 6 + 0.05 * share * kCount) << share << ", seed " << seed;
    }
  }
}

TEST(Penrose, PlacesWrapInUAndReflectInV) {
  // All importance lies in the first and last columns and rows, so displaced samples leave the map.
  std::vector<float> values(64 * 32, 0.0f);
  for (int y = 0; y < 32; ++y) values[y * 64] = values[y * 64 + 63] = 1;
  for (int x = 0; x < 64; ++x) values[x] = values[31 * 64 + x] = 1;
  const MaxPyramid frame = MakeMaxPyramid(64, 32, values);
  int wrapped = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const PenroseSample& s : PenroseSamples(frame, 100, {.seed = seed}).samples) {
      ASSERT_TRUE(s.u >= 0 && s.u < 1 && s.v >= 0 && s.v < 1);
      const int x = int(s.texel % 64), y = int(s.texel / 64);
      double across = std::abs(s.u * 64 - (x + 0.5));
      wrapped += across > 32;
      across = std::min(across, 64 - across);
      EXPECT_LT(across, 12);
      EXPECT_LT(std::abs(s.v * 32 - (y + 0.5)), 12);
      EXPECT_LT(s.v, 1 - 1e-9);  // reflected, not clamped to the edge
    }
  }
  EXPECT_GT(wrapped, 5);
}

TEST(Penrose, SeedsGiveOtherPatterns) {
  const Image image = test::ConstantMap(64, 32, 1);
  const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(image));
  const auto a = PenroseSamples(pyramid, 64, {.seed = 1}),
             b = PenroseSamples(pyramid, 64, {.seed = 2});
  const auto again = PenroseSamples(pyramid, 64, {.seed = 1});
  int same = 0;
  for (int i = 0; i < 64; ++i) {
    same += a.samples[i].texel == b.samples[i].texel;
    EXPECT_EQ(a.samples[i].u, again.samples[i].u);
  }
  EXPECT_LT(same, 8);
}

TEST(Penrose, RefusesBadParameters) {
  const MaxPyramid pyramid = MakeMaxPyramid(2, 1, {1, 2});
  EXPECT_THROW(PenroseSamples(pyramid, 0), InputError);
  EXPECT_THROW(PenroseSamples(pyramid, 4, {.xi = 1}), InputError);
  EXPECT_THROW(PenroseSamples(pyramid, 4, {.xi = NAN}), InputError);
  EXPECT_THROW(PenroseSamplesAtMag(pyramid, -1), InputError);
  EXPECT_THROW(PenroseSamplesAtMag(pyramid, NAN), InputError);
  EXPECT_TRUE(PenroseSamples(MakeMaxPyramid(2, 1, {0, 0}), 4).samples.empty());
  EXPECT_TRUE(PenroseSamplesAtMag(pyramid, 0).samples.empty());
}

// Compares counts in a coarse grid over the map with the importance there. Blue noise is more even
// than Poisson noise, so chi-square stays well below its degrees of freedom.
TEST(Penrose, DensityIsProportionalToImportance) {
  constexpr int kWidth = 512, kHeight = 256, kGridX = 16, kGridY = 8, kCount = 16000;
  for (const bool relax : {false, true}) {
    for (const Image& image :
         {test::ConstantMap(kWidth, kHeight, 1), test::SunMap(kWidth, kHeight, 1)}) {
      const MaxPyramid pyramid = ImportancePyramid(MakeSphereMap(image));
      double expected[kGridY][kGridX] = {}, found[kGridY][kGridX] = {};
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          expected[y * kGridY / kHeight][x * kGridX / kWidth] +=
              kCount * pyramid.At(x, y) / pyramid.sum;
        }
      }
      const PenroseSet set =
          PenroseSamples(pyramid, kCount, {.seed = 3, .xi = 0.5, .relax = relax});
      for (const PenroseSample& s : set.samples) {
        ++found[int(s.v * kGridY)][int(s.u * kGridX)];
      }
      double chi2 = 0, worst = 0;
      for (int y = 0; y < kGridY; ++y) {
        for (int x = 0; x < kGridX; ++x) {
          ASSERT_GT(expected[y][x], 5);
          const double off = (found[y][x] - expected[y][x]) / std::sqrt(expected[y][x]);
          chi2 += off * off;
          worst = std::max(worst, std::abs(off));
        }
      }
      EXPECT_LT(chi2 / (kGridX * kGridY), 0.4);
      EXPECT_LT(worst, 3);
    }
  }
}

// Returns the mean power of the frequencies below half of sqrt(count) cycles per side; 1 for white
// noise.
double LowPower(const std::vector<Complex>& points, double density) {
  // A Hann window prevents the border from leaking into the low frequencies.
  double norm = 0;
  std::vector<double> weight;
  for (Complex p : points) {
    weight.push_back(std::pow(std::sin(kPi * p.re) * std::sin(kPi * p.im), 2));
    norm += weight.back() * weight.back();
  }
  const double limit = 0.5 * std::sqrt(density);
  double sum = 0;
  int count = 0;
  for (int ky = 0; ky <= limit; ++ky) {
    for (int kx = -int(limit); kx <= limit; ++kx) {
      const double f = std::hypot(kx, ky);
      if (f < 3 || f > limit) continue;  // the spectrum of the window itself
      Complex amplitude;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double phase = 2 * kPi * (kx * points[i].re + ky * points[i].im);
        amplitude = amplitude + weight[i] * Complex{std::cos(phase), std::sin(phase)};
      }
      sum += (amplitude.re * amplitude.re + amplitude.im * amplitude.im) / norm;
      ++count;
    }
  }
  return sum / count;
}

TEST(Penrose, SpectrumIsBlue) {
  constexpr int kSide = 64, kCount = 1500;
  const MaxPyramid plane = MakeMaxPyramid(kSide, kSide, std::vector<float>(kSide * kSide, 1.0f));
  double raw = 0, relaxed = 0, white = 0;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform;
  constexpr int kPatterns = 4;
  for (std::uint64_t seed = 1; seed <= kPatterns; ++seed) {
    for (const bool relax : {false, true}) {
      std::vector<Complex> points;
      for (const PenroseSample& s :
           PenroseSamples(plane, kCount + 150 * int(seed), {.seed = seed, .relax = relax})
               .samples) {
        points.push_back({s.u, s.v});
      }
      (relax ? relaxed : raw) += LowPower(points, double(points.size())) / kPatterns;
    }
    std::vector<Complex> points;
    for (int i = 0; i < kCount; ++i) points.push_back({uniform(random), uniform(random)});
    white += LowPower(points, kCount) / kPatterns;
  }
  RecordProperty("raw", std::to_string(raw));
  RecordProperty("relaxed", std::to_string(relaxed));
  std::printf("power below half of sqrt(N): tiling %.4f, relaxed %.4f, white %.3f\n", raw, relaxed,
              white);
  EXPECT_NEAR(white, 1, 0.1);
  EXPECT_LT(raw, 0.25);
  EXPECT_LT(relaxed, 0.07);
}

TEST(Penrose, RelaxedSamplesKeepTheirDistance) {
  constexpr int kSide = 64;
  const MaxPyramid plane = MakeMaxPyramid(kSide, kSide, std::vector<float>(kSide * kSide, 1.0f));
  for (int count : {500, 700, 900, 1200, 1500}) {
    const auto samples = PenroseSamples(plane, count, {.seed = 4}).samples;
    const double hexagonal = std::sqrt(2 / (std::sqrt(3.0) * count));
    double least = 1, sum = 0;
    int inner = 0;
    for (const PenroseSample& a : samples) {
      if (std::abs(a.u - 0.5) > 0.42 || std::abs(a.v - 0.5) > 0.42) continue;
      double nearest = 1;
      for (const PenroseSample& b : samples) {
        if (&a != &b) nearest = std::min(nearest, std::hypot(a.u - b.u, a.v - b.v));
      }
      least = std::min(least, nearest / hexagonal);
      sum += nearest / hexagonal;
      ++inner;
    }
    EXPECT_GT(least, 0.6) << count;
    EXPECT_GT(sum / inner, 0.83) << count;
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
