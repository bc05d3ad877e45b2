// Compares the difference measures with values computed by hand.

#include "image/compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "base/error.h"

namespace skywave {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// The first of two pixels differs by (1, -2, 0.5), the second not at all.
Image Measured() {
  Image image(2, 1);
  image.rgb = {2, 1, 0.5f, 4, 4, 4};
  return image;
}
Image Reference() {
  Image image(2, 1);
  image.rgb = {1, 3, 0, 4, 4, 4};
  return image;
}

TEST(Compare, MatchesAHandCalculation) {
  const ImageDifference d = Compare(Measured(), Reference());
  EXPECT_NEAR(d.mean_a, (0.2125 * 2 + 0.7154 * 1 + 0.0721 * 0.5 + 4) / 2, 1e-6);
  EXPECT_NEAR(d.mean_b, (0.2125 * 1 + 0.7154 * 3 + 4) / 2, 1e-6);
  EXPECT_DOUBLE_EQ(d.mse, (1 + 4 + 0.25) / 6);
  EXPECT_DOUBLE_EQ(d.rmse, std::sqrt((1 + 4 + 0.25) / 6));
  EXPECT_DOUBLE_EQ(d.relative_mse, (1 / 1.01 + 4 / 9.01 + 0.25 / 0.01) / 6);
  EXPECT_DOUBLE_EQ(d.mean_absolute, 3.5 / 6);
  EXPECT_DOUBLE_EQ(d.squared_channel_sum, 3.5 * 3.5 / 2);
  const double luminance = 0.212671 * 1 + 0.715160 * 2 + 0.072169 * 0.5;
  EXPECT_DOUBLE_EQ(d.thesis_luminance, luminance * luminance / 2);
  EXPECT_DOUBLE_EQ(d.max_absolute, 2);
  EXPECT_EQ(d.max_x, 0);
  EXPECT_EQ(d.max_y, 0);
  EXPECT_EQ(d.different_pixels, 1u);
}

TEST(Compare, PsnrIsThatOfTheClippedSrgbPictures) {
  // After clipping and encoding, only blue of the first pixel differs: by the code of 0.5.
  const double code = 1.055 * std::pow(0.5, 1 / 2.4) - 0.055;
  EXPECT_NEAR(Compare(Measured(), Reference()).psnr, 10 * std::log10(6 / (code * code)), 1e-9);
}

TEST(Compare, EqualPicturesDoNotDiffer) {
  const ImageDifference d = Compare(Measured(), Measured());
  EXPECT_EQ(d.mse, 0);
  EXPECT_EQ(d.relative_mse, 0);
  EXPECT_EQ(d.squared_channel_sum, 0);
  EXPECT_EQ(d.max_absolute, 0);
  EXPECT_EQ(d.different_pixels, 0u);
  EXPECT_EQ(d.psnr, std::numeric_limits<double>::infinity());
}

TEST(Compare, BitsDecideAboutNanInfinityAndZero) {
  Image a = Measured(), b = Measured();
  a.rgb[0] = b.rgb[0] = kNan;
  a.rgb[1] = b.rgb[1] = kInf;
  EXPECT_EQ(Compare(a, b).mse, 0);
  EXPECT_EQ(Compare(a, b).different_pixels, 0u);
  a.rgb[2] = 0.0f;
  b.rgb[2] = -0.0f;
  EXPECT_EQ(Compare(a, b).mse, 0);
  EXPECT_EQ(Compare(a, b).different_pixels, 1u);
  a.rgb[4] = kNan;
  const ImageDifference d = Compare(a, b);
  EXPECT_TRUE(std::isnan(d.mse));
  EXPECT_EQ(d.max_absolute, kInf);
  EXPECT_EQ(d.max_x, 1);
}

TEST(Compare, NamesThePlaceOfTheLargestDifference) {
  Image a(5, 4), b(5, 4);
  a.Pixel(3, 2)[1] = -7;
  a.Pixel(4, 3)[2] = 6;
  const ImageDifference d = Compare(a, b);
  EXPECT_EQ(d.max_absolute, 7);
  EXPECT_EQ(d.max_x, 3);
  EXPECT_EQ(d.max_y, 2);
}

TEST(Compare, SmallErrorsSurviveManyPixels) {
  // A float sum would stop growing long before the end.
  Image a(2000, 2000), b(2000, 2000);
  for (float& value : a.rgb) value = 0.125f;
  EXPECT_DOUBLE_EQ(Compare(a, b).mse, 0.015625);
  EXPECT_DOUBLE_EQ(Compare(a, b).mean_absolute, 0.125);
}

TEST(Compare, DifferentSizesAreAnErrorThatNamesThem) {
  try {
    Compare(Image(3, 2), Image(2, 3));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("3 x 2"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("2 x 3"), std::string::npos) << error.what();
  }
  EXPECT_THROW(ErrorMap(Image(3, 2), Image(2, 3)), InputError);
}

TEST(ErrorMap, GetsBrighterWithTheRelativeError) {
  constexpr int kSteps = 101;
  Image a(kSteps, 1), b(kSteps, 1);
  for (int x = 0; x < kSteps; ++x) {
    for (int c = 0; c < 3; ++c) {
      b.Pixel(x, 0)[c] = 0.99f;
      a.Pixel(x, 0)[c] = 0.99f + float(x) / (kSteps - 1);
    }
  }
  const std::vector<std::uint8_t> map = ErrorMap(a, b);
  ASSERT_EQ(map.size(), std::size_t(kSteps) * 3);
  const auto brightness = [&](int x) {
    return 0.2126 * map[x * 3] + 0.7152 * map[x * 3 + 1] + 0.0722 * map[x * 3 + 2];
  };
  EXPECT_LT(brightness(0), 5);
  EXPECT_GT(brightness(kSteps - 1), 230);
  for (int x = 1; x < kSteps; ++x) EXPECT_GE(brightness(x), brightness(x - 1)) << x;

  // At twice the scale the colour is halfway along the ramp; above the scale it is the end of the
  // ramp.
  const std::vector<std::uint8_t> half = ErrorMap(a, b, 2);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(half[100 * 3 + c], map[50 * 3 + c]);
    EXPECT_EQ(ErrorMap(a, b, 0.1)[50 * 3 + c], map[100 * 3 + c]);
  }
}

// Errors of the full scale, a thousandth of it and none are bright, dark and dark; a tenth and a
// hundredth are equally far apart along the ramp of a map of relative error.
TEST(LogErrorMap, ShowsEqualRatiosAsEqualSteps) {
  Image a(5, 1), b(5, 1), ramp(5, 1), zero(5, 1);
  const float errors[] = {0, 2e-4f, 2e-2f, 0.2f, 2};
  const float places[] = {0, 0, 1 / 3.0f, 2 / 3.0f, 1};
  for (int x = 0; x < 5; ++x) {
    for (int c = 0; c < 3; ++c) {
      a.Pixel(x, 0)[c] = 5 + errors[x], b.Pixel(x, 0)[c] = 5;
      ramp.Pixel(x, 0)[c] = places[x];
    }
  }
  const std::vector<std::uint8_t> map = LogErrorMap(a, b, 2);
  const std::vector<float> values(places, places + 5);
  const std::vector<std::uint8_t> expected = FalseColors(values);
  for (std::size_t i = 0; i < map.size(); ++i) EXPECT_NEAR(map[i], expected[i], 1) << i;
  EXPECT_THROW(LogErrorMap(Image(3, 2), Image(2, 3)), InputError);
}

TEST(ErrorMap, ShowsNanAsTheLargestError) {
  Image a = Measured();
  a.rgb[3] = kNan;
  const std::vector<std::uint8_t> map = ErrorMap(a, Measured());
  EXPECT_LT(map[0], 10);
  EXPECT_GT(map[3], 240);
}

}  // namespace
}  // namespace skywave
