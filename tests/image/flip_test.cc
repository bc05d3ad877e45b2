// Compares FLIP with values of its authors' program and with a slow reference written from the
// papers.

#include "image/flip.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "base/error.h"

namespace skywave {
namespace {

constexpr int kWidth = 56, kHeight = 40;

// A smooth picture, and the same with a coloured rectangle, a blue line and a dark bar.
Image Smooth() {
  Image image(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double u = x / double(kWidth - 1), v = y / double(kHeight - 1);
      float* const rgb = image.Pixel(x, y);
      rgb[0] = float(0.1 + 0.8 * u);
      rgb[1] = float(0.2 + 0.6 * v);
      rgb[2] = float(0.5 + 0.36 * std::sin(9 * u + 4 * v));
    }
  }
  return image;
}
Image Changed() {
  Image image = Smooth();
  const auto fill = [&](int x0, int x1, int y0, int y1, const std::function<void(float*)>& change) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) change(image.Pixel(x, y));
    }
  };
  fill(10, 30, 8, 20, [](float* rgb) { rgb[0] = 0.9f, rgb[1] = 0.1f, rgb[2] = 0.2f; });
  fill(0, kWidth, 25, 26, [](float* rgb) { rgb[0] = 0, rgb[1] = 0, rgb[2] = 0.9f; });
  fill(48, 50, 0, kHeight, [](float* rgb) { rgb[0] *= 0.5f, rgb[1] *= 0.5f, rgb[2] *= 0.5f; });
  return image;
}

Image Cubed(Image image) {
  for (float& value : image.rgb) value = 20 * value * value * value;
  return image;
}

Image Plain(float r, float g, float b) {
  Image image(kWidth, kHeight);
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    image.rgb[i] = r, image.rgb[i + 1] = g, image.rgb[i + 2] = b;
  }
  return image;
}

struct Known {
  double mean, rectangle, line, corner;  // the mean, and pixels (20, 14), (5, 25), (55, 39)
};
void ExpectKnown(const Flip& flip, const Known& known) {
  constexpr double kRounding = 2e-4;  // both programs have 32-bit floats
  EXPECT_NEAR(flip.mean, known.mean, kRounding);
  EXPECT_NEAR(flip.map[14 * kWidth + 20], known.rectangle, kRounding);
  EXPECT_NEAR(flip.map[25 * kWidth + 5], known.line, kRounding);
  EXPECT_NEAR(flip.map[39 * kWidth + 55], known.corner, kRounding);
}

// All known values come from the package flip-evaluator 1.7 of the authors, with linear light as
// its input.
TEST(Flip, AgreesWithTheProgramOfItsAuthors) {
  ExpectKnown(LdrFlip(Smooth(), Changed(), 67), {0.2626773, 0.959819, 0.725689, 0.059912});
  ExpectKnown(LdrFlip(Smooth(), Changed(), 30), {0.2303469, 0.958515, 0.976839, 0});
}

TEST(Flip, HdrAgreesWithTheProgramOfItsAuthors) {
  const Flip flip = HdrFlip(Cubed(Smooth()), Cubed(Changed()));
  ExpectKnown(flip, {0.3366017, 0.975532, 0.824501, 0.113504});
  EXPECT_NEAR(flip.first_stops, -2.352628, 1e-5);
  EXPECT_NEAR(flip.last_stops, -0.573799, 1e-5);
  EXPECT_EQ(flip.exposures, 2);
  // The exposures come from the reference, so the pictures do not play the same part.
  const Flip swapped = HdrFlip(Cubed(Changed()), Cubed(Smooth()));
  EXPECT_NEAR(swapped.mean, 0.3356933, 2e-4);
  EXPECT_NEAR(swapped.last_stops, -0.660752, 1e-5);
}

TEST(Flip, PlainColoursMatchTheAuthorsProgram) {
  const Image black = Plain(0, 0, 0);
  EXPECT_NEAR(LdrFlip(Plain(1, 1, 1), black).mean, 0.967392, 1e-5);
  EXPECT_NEAR(LdrFlip(Plain(0, 1, 0), black).mean, 0.996970, 1e-5);
  EXPECT_NEAR(LdrFlip(Plain(0, 1, 0), Plain(0, 0, 1)).mean, 1, 1e-6);
}

TEST(Flip, LdrIsSymmetricAndZeroForEqualPictures) {
  EXPECT_EQ(LdrFlip(Smooth(), Changed()).map, LdrFlip(Changed(), Smooth()).map);
  EXPECT_EQ(LdrFlip(Changed(), Changed()).mean, 0);
  EXPECT_EQ(HdrFlip(Cubed(Changed()), Cubed(Changed())).mean, 0);
}

TEST(Flip, LargerChangesNeverLowerIt) {
  double before = 0;
  for (const float change : {0.02f, 0.1f, 0.4f, 0.9f}) {
    const double mean = LdrFlip(Plain(change, 0.1f, 0.1f), Plain(0, 0.1f, 0.1f)).mean;
    EXPECT_GT(mean, before);
    before = mean;
  }
  EXPECT_LE(before, 1);
}

// What is no radiance counts as 0, and the rest stays finite, whatever the reference holds.
TEST(Flip, IsFiniteForEveryInput) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Image odd = Cubed(Smooth()), repaired = odd;
  const float values[] = {kNan, kInf, -kInf, -1};
  for (std::size_t i = 0; i < std::size(values); ++i) {
    odd.rgb[300 * i] = values[i];
    repaired.rgb[300 * i] = values[i] == kInf ? 65504.0f : 0;  // RepairRadiance
  }
  EXPECT_EQ(HdrFlip(odd, Cubed(Changed())).map, HdrFlip(repaired, Cubed(Changed())).map);
  const Image black = Plain(0, 0, 0), huge = Plain(3e38f, 3e38f, 3e38f);
  Image one_pixel = black;
  one_pixel.rgb[0] = 1e-30f;
  const Image* const pictures[] = {&black, &huge, &one_pixel, &odd};
  for (const Image* const image : pictures) {
    for (const Image* const reference : pictures) {
      const Flip flip = HdrFlip(*image, *reference);
      for (const float value : flip.map) ASSERT_TRUE(value >= 0 && value <= 1) << value;
      for (const float value : LdrFlip(*image, *reference).map) {
        ASSERT_TRUE(value >= 0 && value <= 1) << value;
      }
    }
  }
}

TEST(Flip, NeedsEqualSizes) {
  EXPECT_THROW(LdrFlip(Image(4, 3), Image(3, 4)), InputError);
  EXPECT_THROW(HdrFlip(Image(4, 3), Image(3, 4)), InputError);
}

// All are 1 but for a pixel that is 2.5 stops brighter.
TEST(Flip, HasAnExposureForEveryStop) {
  Image reference = Plain(1, 1, 1);
  for (int c = 0; c < 3; ++c) reference.rgb[std::size_t(c)] = float(std::exp2(2.5));
  const Flip flip = HdrFlip(Plain(1, 1, 1), reference);
  EXPECT_NEAR(flip.last_stops - flip.first_stops, 2.5, 1e-5);
  EXPECT_EQ(flip.exposures, 3);
}

// Six tenths are black; most of the rest is 2, and a little is 8.
TEST(Flip, MedianOfADarkPictureIsOverItsLitPixels) {
  Image reference = Plain(0, 0, 0);
  const std::size_t pixels = reference.rgb.size() / 3;
  for (std::size_t i = 0; i < pixels * 4 / 10; ++i) {
    for (std::size_t c = 0; c < 3; ++c) reference.rgb[3 * i + c] = i % 8 == 0 ? 8.0f : 2.0f;
  }
  const Flip flip = HdrFlip(reference, reference);
  EXPECT_NEAR(flip.last_stops - flip.first_stops, 2, 1e-5);
  // The longest exposure shows the median at 0.85 (Narkowicz's curve, at 0.6 of the light).
  const double x = 0.6 * 2 * std::exp2(flip.last_stops);
  EXPECT_NEAR(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.85, 1e-5);
}

}  // namespace
}  // namespace skywave
