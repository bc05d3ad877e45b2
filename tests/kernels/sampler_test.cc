// Compares random numbers, the documented hashes, with a scalar transcription that uses real
// direction numbers, and tests the properties on which rendering relies.

#include "kernels/sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/support/random_rows.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

// The following functions transcribe Burley 2020 in scalar code.

std::uint32_t Reverse(std::uint32_t x) {
  std::uint32_t reversed = 0;
  for (int bit = 0; bit < 32; ++bit) reversed |= (x >> bit & 1u) << (31 - bit);
  return reversed;
}

// Returns the first or second coordinate of a Sobol' point by direction numbers: 2^31 / 2^j, and
// those of the primitive polynomial x + 1, v_j = v_(j-1) xor v_(j-1) / 2.
std::uint32_t Sobol(std::uint32_t index, int dimension) {
  std::uint32_t direction = 1u << 31, point = 0;
  for (; index != 0; index >>= 1) {
    if (index & 1u) point ^= direction;
    direction = dimension == 0 ? direction >> 1 : direction ^ direction >> 1;
  }
  return point;
}

std::uint32_t OwenScramble(std::uint32_t x, std::uint32_t seed) {
  x = Reverse(x);
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= seed >> 16 | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return Reverse(x);
}

std::uint32_t Mix(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ x >> 16;
}

struct Point {
  float u, v;
};
Point Reference(std::uint32_t pixel_seed, std::uint32_t sample, std::uint32_t pair,
                SampleIndexing indexing) {
  const std::uint32_t base = Mix(pixel_seed ^ pair * 0x9E3779B9u);
  const std::uint32_t u_seed = Mix(base);
  const std::uint32_t v_seed = u_seed * 0xC2B2AE35u ^ u_seed >> 15;
  const std::uint32_t index = sample * indexing.stride + indexing.offset;
  const std::uint32_t shuffled = OwenScramble(index, base * 0x85EBCA6Bu);
  const auto unit = [](std::uint32_t bits) { return float(bits >> 8) * 0x1p-24f; };
  return {unit(OwenScramble(Sobol(shuffled, 0), u_seed)),
          unit(OwenScramble(Sobol(shuffled, 1), v_seed))};
}

std::vector<Point> Draw(const std::vector<std::uint32_t>& seeds,
                        const std::vector<std::uint32_t>& samples, std::uint32_t pair,
                        SampleIndexing indexing = {}) {
  const auto n = std::uint32_t(seeds.size());
  soa::Table<PathColumns> paths(n);
  std::copy(seeds.begin(), seeds.end(), paths->seed);
  std::copy(samples.begin(), samples.end(), paths->sample);
  soa::Table<UniformColumns> out(n);
  DrawUniforms(paths, nullptr, n, pair, indexing, out);
  std::vector<Point> points(n);
  for (std::uint32_t i = 0; i < n; ++i) points[i] = {out->u[i], out->v[i]};
  return points;
}
// Returns samples [first, first + n) of one pixel.
std::vector<Point> DrawPixel(std::uint32_t seed, std::uint32_t first, std::uint32_t n,
                             std::uint32_t pair, SampleIndexing indexing = {}) {
  std::vector<std::uint32_t> samples(n);
  for (std::uint32_t i = 0; i < n; ++i) samples[i] = first + i;
  return Draw(std::vector<std::uint32_t>(n, seed), samples, pair, indexing);
}

TEST(Sampler, MatchesTheScalarScheme) {
  Random random(71);
  std::vector<std::uint32_t> seeds(kFullWave), samples(kFullWave);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    seeds[i] = random.Word();
    samples[i] = i % 2 == 0 ? i : random.Word();
  }
  seeds[0] = 0, samples[0] = 0, seeds[1] = 0xFFFFFFFFu, samples[1] = 0xFFFFFFFFu;
  for (const std::uint32_t pair : {0u, 1u, 2u, 17u, 1000u}) {
    for (const SampleIndexing indexing : {SampleIndexing{}, SampleIndexing{8, 5}}) {
      ForEachTarget([&] {
        const auto points = Draw(seeds, samples, pair, indexing);
        for (std::uint32_t i = 0; i < kFullWave; ++i) {
          const Point exact = Reference(seeds[i], samples[i], pair, indexing);
          ASSERT_EQ(points[i].u, exact.u) << "row " << i;
          ASSERT_EQ(points[i].v, exact.v) << "row " << i;
          ASSERT_TRUE(points[i].u >= 0 && points[i].u < 1 && points[i].v >= 0 && points[i].v < 1);
        }
      });
    }
  }
}

TEST(Sampler, RowsAreIndirectAndOfAnyNumber) {
  constexpr std::uint32_t kPaths = 500;
  soa::Table<PathColumns> paths(kPaths);
  Random random(72);
  for (std::uint32_t i = 0; i < kPaths; ++i) paths->seed[i] = random.Word(), paths->sample[i] = i;
  std::vector<std::uint32_t> rows(PaddedRows(kFullWave), 0xFFFFFFFFu);
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      // Rows from n on hold invalid indices.
      std::fill(rows.begin(), rows.end(), 0x7FFFFFFFu);
      for (std::uint32_t i = 0; i < n; ++i) rows[i] = (i * 7919u) % kPaths;
      soa::Table<UniformColumns> out(kFullWave);
      DrawUniforms(paths, rows.data(), n, 4, {3, 1}, out);
      for (std::uint32_t i = 0; i < n; ++i) {
        const Point exact = Reference(paths->seed[rows[i]], paths->sample[rows[i]], 4, {3, 1});
        ASSERT_EQ(out->u[i], exact.u) << "row " << i << " of " << n;
        ASSERT_EQ(out->v[i], exact.v) << "row " << i << " of " << n;
      }
    }
  });
}

// Expects 2^k points, one in every elementary interval of area 2^-k.
void ExpectNet(const std::vector<Point>& points) {
  int k = 0;
  while (1u << k < points.size()) ++k;
  for (int a = 0; a <= k; ++a) {
    std::set<std::pair<int, int>> cells;
    for (const Point point : points) {
      cells.emplace(int(point.u * float(1 << a)), int(point.v * float(1 << (k - a))));
    }
    ASSERT_EQ(cells.size(), points.size()) << (1 << a) << " x " << (1 << (k - a)) << " cells";
  }
}

TEST(Sampler, AlignedBlocksAreNets) {
  Random random(73);
  for (int pixel = 0; pixel < 8; ++pixel) {
    const std::uint32_t seed = random.Word();
    for (const std::uint32_t pair : {0u, 1u, 5u}) {
      for (int k = 0; k <= 10; ++k) {
        for (const std::uint32_t block : {0u, 1u, 6u, 1001u}) {
          ExpectNet(DrawPixel(seed, block << k, 1u << k, pair));
        }
      }
    }
  }
}

// The n light samples of a hit are points of one sequence.
TEST(Sampler, StridedSamplesAreNetsTogether) {
  constexpr std::uint32_t kStride = 8, kSamples = 16;
  std::vector<Point> together;
  for (std::uint32_t offset = 0; offset < kStride; ++offset) {
    const auto points = DrawPixel(99, 0, kSamples, 3, {kStride, offset});
    together.insert(together.end(), points.begin(), points.end());
    const auto plain = DrawPixel(99, offset, 1, 3);
    EXPECT_EQ(points[0].u, plain[0].u);
  }
  ExpectNet(together);
  // The light samples of a single camera sample form a net too.
  std::vector<Point> one;
  for (std::uint32_t j = 0; j < kStride; ++j)
    one.push_back(DrawPixel(99, 5, 1, 3, {kStride, j})[0]);
  ExpectNet(one);
}

// Compares counts of two coordinates in 16 x 16 cells with independence.
testing::AssertionResult AreIndependent(const std::vector<float>& a, const std::vector<float>& b) {
  constexpr int kSide = 16;
  std::vector<double> observed(kSide * kSide);
  for (std::size_t i = 0; i < a.size(); ++i)
    ++observed[std::size_t(int(a[i] * kSide) * kSide + int(b[i] * kSide))];
  const std::vector<double> expected(observed.size(), double(a.size()) / double(observed.size()));
  return MatchesExpected(observed, expected, SidakLevel(100));
}
std::vector<float> U(const std::vector<Point>& points) {
  std::vector<float> values;
  for (const Point point : points) values.push_back(point.u);
  return values;
}
std::vector<float> V(const std::vector<Point>& points) {
  std::vector<float> values;
  for (const Point point : points) values.push_back(point.v);
  return values;
}

// Returns sample `sample` of every pixel of a picture.
std::vector<Point> DrawPicture(std::uint32_t sample, std::uint32_t pair, std::uint32_t shift_x,
                               std::uint32_t frame_seed) {
  std::vector<std::uint32_t> seeds;
  for (std::uint32_t y = 0; y < 128; ++y) {
    for (std::uint32_t x = 0; x < 128; ++x) seeds.push_back(PixelSeed(x + shift_x, y, frame_seed));
  }
  return Draw(seeds, std::vector<std::uint32_t>(seeds.size(), sample), pair);
}

TEST(Sampler, PixelsPairsAndFramesAreIndependent) {
  const auto base = DrawPicture(0, 0, 0, 0);
  EXPECT_TRUE(IsUniform(U(base), SidakLevel(100)));
  EXPECT_TRUE(IsUniform(V(base), SidakLevel(100)));
  EXPECT_TRUE(AreIndependent(U(base), V(base))) << "u and v";
  EXPECT_TRUE(AreIndependent(U(base), U(DrawPicture(0, 0, 1, 0)))) << "neighbours";
  EXPECT_TRUE(AreIndependent(V(base), V(DrawPicture(0, 0, 1, 0)))) << "neighbours";
  EXPECT_TRUE(AreIndependent(U(base), U(DrawPicture(0, 0, 0, 1)))) << "frames";
  for (std::uint32_t pair = 1; pair <= 8; ++pair) {
    const auto other = DrawPicture(0, pair, 0, 0);
    EXPECT_TRUE(AreIndependent(U(base), U(other))) << "pair " << pair;
    EXPECT_TRUE(AreIndependent(V(base), V(other))) << "pair " << pair;
    EXPECT_TRUE(AreIndependent(U(base), V(other))) << "pair " << pair;
  }
}

// Within a pixel, each pair has its own order of samples. Points of nets are not independent of
// each other, so the correlation of one pixel is a single observation, and there are many pixels.
TEST(Sampler, PairsOfAPixelAreUncorrelated) {
  constexpr std::uint32_t kPixels = 1000, kSamples = 64;
  for (std::uint32_t pair = 1; pair <= 6; ++pair) {
    Moments uu, vv, uv;
    for (std::uint32_t pixel = 0; pixel < kPixels; ++pixel) {
      const std::uint32_t seed = PixelSeed(pixel, 5, 9);
      const auto a = DrawPixel(seed, 0, kSamples, 0), b = DrawPixel(seed, 0, kSamples, pair);
      double sum_uu = 0, sum_vv = 0, sum_uv = 0;
      for (std::uint32_t i = 0; i < kSamples; ++i) {
        sum_uu += (a[i].u - 0.5) * (b[i].u - 0.5);
        sum_vv += (a[i].v - 0.5) * (b[i].v - 0.5);
        sum_uv += (a[i].u - 0.5) * (b[i].v - 0.5);
      }
      uu.Add(12 * sum_uu / kSamples), vv.Add(12 * sum_vv / kSamples);
      uv.Add(12 * sum_uv / kSamples);
    }
    for (const Moments& correlation : {uu, vv, uv}) {
      EXPECT_TRUE(AgreesWith(correlation.mean(), correlation.standard_error(), 0, SidakLevel(18)))
          << "pair " << pair;
      // Equal orders would give +-1 in every pixel; independent samples have 1 / sqrt(64).
      EXPECT_LT(std::sqrt(correlation.variance()), 0.2) << "pair " << pair;
    }
  }
}

TEST(Sampler, PixelsHaveSeedsOfTheirOwn) {
  std::set<std::uint32_t> seeds;
  for (std::uint32_t y = 0; y < 512; ++y) {
    for (std::uint32_t x = 0; x < 512; ++x) seeds.insert(PixelSeed(x, y, 0));
  }
  // Among 2^18 random words of 32 bits, about 8 collide.
  EXPECT_GT(seeds.size(), 512u * 512u - 40);
  EXPECT_NE(PixelSeed(1, 0, 0), PixelSeed(0, 1, 0));
  EXPECT_NE(PixelSeed(0, 0, 0), PixelSeed(0, 0, 1));
}

TEST(Sampler, PairsOfAPathAreDistinct) {
  std::set<std::uint32_t> pairs = {kFilmPair, kLensPair};
  EXPECT_EQ(pairs.size(), 2u);
  for (std::uint32_t bounce = 0; bounce < 50; ++bounce) {
    for (const SampleUse use : {SampleUse::kLight, SampleUse::kScatter, SampleUse::kLobe}) {
      EXPECT_TRUE(pairs.insert(SamplePair(bounce, use)).second);
    }
  }
}

}  // namespace
}  // namespace skywave
