// Tests pictures that Open Image Denoise cleans, by a library that stands in for it, and the best
// of both denoisers.
#include "job/denoise/oidn.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>

#include "base/error.h"
#include "tests/support/noisy_picture.h"

namespace skywave {
namespace {

// The library is looked for once in a process.
class WithStandIn : public testing::Environment {
 public:
  void SetUp() override { setenv("SKYWAVE_OIDN", SKYWAVE_STAND_IN_OIDN, 1); }
};
const testing::Environment* const kStandIn = testing::AddGlobalTestEnvironment(new WithStandIn);

Pixel Level(int, int) { return {}; }
// Blurring an edge is wrong there, and right elsewhere.
Pixel Edge(int x, int) { return {.light = x < kSide / 2 ? 1.0 : 6.0, .deviation = 0.5}; }

// What the stand-in makes of a picture.
Image Blurred(const Image& image) {
  Image blurred(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int k = 0; k < 25; ++k) {
          const int column = std::clamp(x + k % 5 - 2, 0, image.width - 1);
          const int row = std::clamp(y + k / 5 - 2, 0, image.height - 1);
          sum += double(image.Pixel(column, row)[c]);
        }
        blurred.Pixel(x, y)[c] = float(sum / 25);
      }
    }
  }
  return blurred;
}

TEST(Oidn, CleansThePictureAndNotTheMap) {
  ASSERT_EQ(OidnVersion(), "2.98.3");
  Noisy noisy = Draw(Level, 1);
  for (int y = 0; y < kSide; ++y) {
    std::fill_n(noisy.at("coverage.V").begin() + y * kSide, 20, 0.0f);
  }
  const Denoised clean = Clean(noisy, Denoiser::kOidn);
  EXPECT_EQ(clean.oidn, "2.98.3");
  const Image blurred = Blurred(noisy.image);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const Image& expected = x < 20 ? noisy.image : blurred;
      ASSERT_NEAR(clean.image.Pixel(x, y)[1], expected.Pixel(x, y)[1], 1e-5f) << x << " " << y;
    }
  }
}

TEST(Oidn, QuickPicturesAreTheSameWithoutError) {
  const Noisy noisy = Draw(Level, 1);
  const Denoised whole = Clean(noisy, Denoiser::kOidn), quick = Clean(noisy, Denoiser::kQuick);
  EXPECT_EQ(quick.image.rgb, whole.image.rgb);
  EXPECT_EQ(quick.oidn, whole.oidn);
  EXPECT_EQ(whole.error.size(), 3u);
  EXPECT_TRUE(quick.error.empty());
}

struct Misses {
  double share = 0, mean_squared_z = 0;
};
// How many values are not within 1.96 errors of the truth.
Misses MissesOf(const Denoised& clean, const Truth& truth) {
  Misses misses;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const std::size_t pixel = std::size_t(y) * kSide + std::size_t(x);
      const double z = (double(clean.image.rgb[3 * pixel]) - TrueValue(truth(x, y))) /
                       double(clean.error[0].values[pixel]);
      misses.share += std::abs(z) > 1.96, misses.mean_squared_z += z * z;
    }
  }
  misses.share /= kSide * kSide, misses.mean_squared_z /= kSide * kSide;
  return misses;
}

TEST(Oidn, ErrorsCoverNoiseAndBias) {
  for (const Truth& truth : {Truth(Level), Truth(Edge)}) {
    for (const Denoiser by : {Denoiser::kOidn, Denoiser::kBest}) {
      const Misses misses = MissesOf(Clean(Draw(truth, 5), by), truth);
      EXPECT_LT(misses.share, 0.09) << ToString(by);
      EXPECT_GT(misses.share, 0.005) << ToString(by);
      EXPECT_LT(misses.mean_squared_z, 1.6) << ToString(by);
    }
  }
}

// On a level both are right; next to an edge the stand-in is wrong over two pixels.
TEST(Best, IsNoWorseThanTheNetworkAndMuchBetterWhereThatIsWrong) {
  for (const auto& [truth, factor] : {std::pair(Truth(Level), 1.0), {Truth(Edge), 0.02}}) {
    double best = 0, oidn = 0;
    for (std::uint32_t seed = 0; seed < 3; ++seed) {
      const Noisy noisy = Draw(truth, seed);
      const Denoised by_both = Clean(noisy, Denoiser::kBest);
      best += SquaredError(by_both.image, truth);
      oidn += SquaredError(Clean(noisy, Denoiser::kOidn).image, truth);
      EXPECT_NEAR(by_both.shares[0] + by_both.shares[1] + by_both.shares[2], 1, 1e-6);
      EXPECT_LT(by_both.shares[2], 0.1);
    }
    EXPECT_LT(best, factor * oidn);
  }
}

// Where neither finds anything alike, the noisy picture is best.
TEST(Best, LeavesWhatIsCleanAlone) {
  const Truth fine = [](int x, int y) {
    return Pixel{.light = 1 + 0.9 * std::sin(7.0 * x * y + x), .deviation = 1e-3};
  };
  const Noisy noisy = Draw(fine, 2);
  const Denoised best = Clean(noisy, Denoiser::kBest);
  EXPECT_LT(best.shares[1], 0.01);
  EXPECT_LT(SquaredError(best.image, fine), 1.2 * SquaredError(noisy.image, fine));
}

}  // namespace
}  // namespace skywave
