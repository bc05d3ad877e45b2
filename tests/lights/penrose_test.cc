// Tests the Penrose sampler against the given importance, and the pyramid of maxima that it asks.

#include "lights/light_sets/penrose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "base/error.h"
#include "lights/light_sets/penrose_corrections.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

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

}  // namespace
}  // namespace skywave
