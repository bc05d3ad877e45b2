// Tests the fit of pixels to the features around them, on planes whose truth is known.
#include "kernels/feature_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "wavefront/soa.h"

namespace skywave {
namespace {

constexpr int kSide = 40;
constexpr float kBrightness = 4;

// Planes of a picture whose features are random, and which is not filtered yet.
struct Planes {
  PlaneShape shape = {kSide, kSide};
  soa::Table<FeaturePlanes> features{std::uint32_t(shape.size())};
  soa::Table<TexturePlanes> texture{std::uint32_t(shape.size())};
  soa::Table<HalfPlanes> noisy[2] = {Half(), Half()}, in[2] = {Half(), Half()},
                         out[2] = {Half(), Half()};
  std::mt19937 random{7};

  soa::Table<HalfPlanes> Half() const {
    return soa::Table<HalfPlanes>(std::uint32_t(shape.size()));
  }

  Planes() {
    for (std::size_t i = 0; i < shape.size(); ++i) features->coverage[i] = kNoCoverage;
    std::uniform_real_distribution<float> uniform(0, 2);
    ForEach([&](std::size_t i) {
      const FeaturePlanes& f = features;
      for (float* plane :
           {f.normal_x, f.normal_y, f.normal_z, f.albedo_r, f.albedo_g, f.albedo_b}) {
        plane[i] = uniform(random);
      }
      f.depth[i] = 20 * uniform(random);
      f.coverage[i] = (0.5f + uniform(random) / 4) / kCoverageUnit;
      texture->r[i] = 0.5f * kBrightness, texture->g[i] = 1 * kBrightness;
      texture->b[i] = 2 * kBrightness;
    });
  }

  void ForEach(const std::function<void(std::size_t)>& f) const {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) f(shape.at(x, y));
    }
  }

  // Sets both halves of pixel i of `in` to radiance `value`, in units of the brightness, with the
  // noise v of the mean of its channels.
  void Set(std::size_t i, float value, float v) {
    for (int half = 0; half < 2; ++half) SetHalf(half, i, value, v);
  }
  void SetHalf(int half, std::size_t i, float value, float v) {
    const HalfPlanes& h = in[half];
    h.r[i] = 2 * value, h.g[i] = value, h.b[i] = value / 2;
    h.noise[i] = v / (5.25f / 3);  // by the mean square of the textures
    noisy[half]->noise[i] = h.noise[i];
  }

  void Fit() {
    const HalfPlanes from[2] = {noisy[0], noisy[1]}, mean[2] = {in[0], in[1]},
                     to[2] = {out[0], out[1]};
    for (int y = 0; y < kSide; ++y) {
      FitToFeatures(shape, features, texture, kBrightness, from, mean, y, to);
    }
  }
};

// A function of the features that is linear, as in pixels that show shares of two surfaces.
float LinearIn(const FeaturePlanes& f, std::size_t i) {
  const float share = f.coverage[i] * kCoverageUnit, depth = std::exp(kDepthUnit * f.depth[i]);
  const float surface = 0.5f * f.normal_x[i] - 0.25f * f.normal_z[i] + 0.3f * f.albedo_g[i];
  return 3 + share * (surface + depth - 1);
}

TEST(FeatureFit, FindsLinearFunctions) {
  Planes planes;
  const std::size_t middle = planes.shape.at(20, 20), corner = planes.shape.at(0, kSide - 1);
  planes.ForEach([&](std::size_t i) {
    const bool is_noisy = i == middle || i == corner;
    planes.Set(i, LinearIn(planes.features, i) + (is_noisy ? 1.0f : 0), is_noisy ? 1.0f : 1e-6f);
  });
  planes.Fit();
  for (const std::size_t i : {middle, corner}) {
    const float truth = LinearIn(planes.features, i);
    for (const soa::Table<HalfPlanes>& half : planes.out) {
      // The ridge leaves some of the error, which was 1.
      EXPECT_NEAR(half->r[i], 2 * truth, 0.08);
      EXPECT_NEAR(half->g[i], truth, 0.04);
      EXPECT_NEAR(half->b[i], truth / 2, 0.02);
      EXPECT_LT(half->noise[i], 1e-2f);
    }
  }
}

// Values far beyond the noise stay as they are, those that it might explain move by a third of
// their 0.075 on average; by half if what the fit leaves did not count.
TEST(FeatureFit, LeavesWhatFeaturesDoNotExplain) {
  for (const float range : {1.0f, 0.15f}) {
    SCOPED_TRACE(range);
    Planes planes;
    std::uniform_real_distribution<float> uniform(2 - range, 2 + range);
    planes.ForEach([&](std::size_t i) { planes.Set(i, uniform(planes.random), 0.01f); });
    planes.Fit();
    double moved = 0;
    planes.ForEach([&](std::size_t i) {
      moved += std::abs(planes.out[0]->g[i] - planes.in[0]->g[i]) / (kSide * kSide);
    });
    EXPECT_LT(moved, 0.03);
  }
}

// Light that is known, as that of an open plane by a control variate, has noise of rounding or
// none.
TEST(FeatureFit, LeavesPixelsWithoutNoise) {
  for (const float around : {0.0f, 1e-38f, 1e8f}) {
    for (const float here : {2.5e-45f, 1e-38f, 1e-30f}) {
      Planes planes;
      const std::size_t middle = planes.shape.at(0, 20);
      planes.ForEach([&](std::size_t i) { planes.Set(i, 2, i == middle ? here : around); });
      planes.Fit();
      planes.ForEach([&](std::size_t i) {
        ASSERT_NEAR(planes.out[0]->g[i], 2, 1e-4) << around << ' ' << here;
        ASSERT_TRUE(std::isfinite(planes.out[1]->noise[i])) << around << ' ' << here;
      });
    }
  }
}

// One half says whether the other one is replaced.
TEST(FeatureFit, LeavesHalvesWhoseOtherOneIsFarFromItsFit) {
  Planes planes;
  const std::size_t middle = planes.shape.at(20, 20);
  planes.ForEach([&](std::size_t i) { planes.Set(i, LinearIn(planes.features, i), 1e-6f); });
  planes.SetHalf(0, middle, LinearIn(planes.features, middle) + 20, 1);
  planes.SetHalf(1, middle, LinearIn(planes.features, middle) + 1, 1);
  planes.Fit();
  const float truth = LinearIn(planes.features, middle);
  EXPECT_NEAR(planes.out[0]->g[middle], truth, 0.05);
  EXPECT_NEAR(planes.out[1]->g[middle], truth + 1, 1e-5);
}

// What one half takes for certain decides what is fitted in the other one, so that nothing is
// favoured for being dark and certain by chance.
TEST(FeatureFit, WeighsAHalfByTheNoiseOfTheOther) {
  Planes planes;
  planes.ForEach([&](std::size_t i) {
    const bool is_odd = i % 2 == 1;
    planes.SetHalf(0, i, is_odd ? 1.4f : 1.6f, is_odd ? 1e-6f : 0.2f);
    planes.SetHalf(1, i, is_odd ? 1.4f : 1.6f, is_odd ? 0.2f : 1e-6f);
  });
  const std::size_t middle = planes.shape.at(20, 20);
  planes.Set(middle, 1.5f, 0.04f);
  planes.Fit();
  EXPECT_GT(planes.out[0]->g[middle], 1.51f);
  EXPECT_LT(planes.out[1]->g[middle], 1.49f);
}

TEST(FeatureFit, LeavesPixelsThatHaveLostTheirNoise) {
  Planes planes;
  std::uniform_real_distribution<float> uniform(1, 3);
  planes.ForEach([&](std::size_t i) {
    planes.Set(i, uniform(planes.random), 1);
    planes.in[0]->noise[i] = planes.in[1]->noise[i] = 0.05f * planes.noisy[0]->noise[i];
  });
  planes.Fit();
  planes.ForEach([&](std::size_t i) {
    ASSERT_EQ(planes.out[0]->r[i], planes.in[0]->r[i]);
    ASSERT_EQ(planes.out[1]->b[i], planes.in[1]->b[i]);
    ASSERT_EQ(planes.out[1]->noise[i], planes.in[1]->noise[i]);
  });
}

// The noise that is left is what the values vary by. All channels are alike.
TEST(FeatureFit, KnowsTheNoiseThatIsLeft) {
  Planes planes;
  std::normal_distribution<float> normal(0, 0.1f);
  planes.ForEach([&](std::size_t i) {
    for (int half = 0; half < 2; ++half) {
      planes.SetHalf(half, i, 2 + normal(planes.random), 3 * 0.01f);
    }
  });
  planes.Fit();
  double variance = 0, stated = 0;
  planes.ForEach([&](std::size_t i) {
    variance += std::pow(double(planes.out[0]->g[i]) - 2, 2);
    stated += double(planes.out[0]->noise[i]) * 5.25 / 3 / 3;
  });
  EXPECT_LT(stated, 0.7 * 0.01 * kSide * kSide);
  EXPECT_NEAR(variance / stated, 1, 0.15);
}

}  // namespace
}  // namespace skywave
