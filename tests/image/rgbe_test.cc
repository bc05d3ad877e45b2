// Tests Radiance files: values, runs, orientations.
#include <gtest/gtest.h>

#include <limits>

#include "image/image.h"
#include "tests/support/image_test_files.h"

namespace skywave {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST_F(ImageFiles, RgbeIsExactForRepresentableValues) {
  for (const int width : {1, 7, 8, 127, 128, 300, 40000}) {  // flat and run-length coded
    const Image image = Numbered(width, 3);
    WriteRgbe(Path("a.hdr"), image);
    ReadLimits wide;
    wide.max_width = 40000;
    ExpectSame(ReadImage(Path("a.hdr"), wide), image);
  }
  Image extremes(1, 3);
  extremes.rgb = {0x1p-128f, 0, 0, 0x1.FEp126f, 0x1p119f, 0, 255, 128, 1};
  WriteRgbe(Path("b.hdr"), extremes);
  ExpectSame(ReadImage(Path("b.hdr")), extremes);
}

TEST_F(ImageFiles, RgbeKeepsRuns) {
  Image image(700, 1);
  for (int x = 0; x < image.width; ++x) {
    // The runs have 1 to 300 pixels, including the lengths at which run coding starts and stops to
    // pay.
    const int run = x < 3 ? 0 : x < 7 ? 1 : x < 10 ? 2 : x < 138 ? 3 : x < 400 ? 4 : x;
    for (int c = 0; c < 3; ++c) image.Pixel(x, 0)[c] = float(128 + run % 100);
  }
  WriteRgbe(Path("a.hdr"), image);
  ExpectSame(ReadImage(Path("a.hdr")), image);
  WriteRgbe(Path("black.hdr"), Image(700, 50));
  ExpectSame(ReadImage(Path("black.hdr")), Image(700, 50));
  EXPECT_LT(std::filesystem::file_size(Path("black.hdr")), 50 * 60u);
}

TEST_F(ImageFiles, RgbeRoundsToNearest) {
  Image image(200, 1);
  for (int i = 0; i < 600; ++i) image.rgb[i] = std::exp(0.05f * float(i * 37 % 600) - 15);
  image.rgb[0] = image.rgb[1] = 255.75f;  // rounds up into the next exponent
  WriteRgbe(Path("a.hdr"), image);
  const Image back = ReadImage(Path("a.hdr"));
  for (int x = 0; x < image.width; ++x) {
    const float* const pixel = image.Pixel(x, 0);
    const float largest = std::max({pixel[0], pixel[1], pixel[2]});
    for (int c = 0; c < 3; ++c) {
      EXPECT_LE(std::abs(back.Pixel(x, 0)[c] - pixel[c]), largest / 256) << x;
    }
  }
}

TEST_F(ImageFiles, RgbeClampsValuesOutOfRange) {
  Image image(3, 1);
  image.rgb = {kNan, -1, 2, kInf, 1, 0, -kInf, 1e-40f, 0};
  WriteRgbe(Path("a.hdr"), image);
  EXPECT_EQ(ReadImage(Path("a.hdr")).rgb,
            (std::vector<float>{0, 0, 2, 0x1.FEp126f, 0, 0, 0, 0, 0}));
}

std::string RgbeFile(const std::string& resolution, const std::string& pixels) {
  return "#?RGBE\n# comment\nGAMMA=2\nFORMAT=32-bit_rle_rgbe\n\n" + resolution + "\n" + pixels;
}

TEST_F(ImageFiles, RgbeDecodesAsDocumented) {
  // Gamma is not applied; mantissas are neither rounded nor shifted by half a step.
  const Image image = ReadImage(
      Put("a.hdr", RgbeFile("-Y 1 +X 2", "\x80\x01\xff\x88\x80\x80\x80" + std::string(1, '\0'))));
  EXPECT_EQ(image.rgb, (std::vector<float>{128, 1, 255, 0, 0, 0}));
}

TEST_F(ImageFiles, RgbeOfEveryOrientation) {
  // The picture has two columns and three rows, with the red channel numbered by rows: 0 1 / 2 3 /
  // 4 5.
  const std::pair<const char*, std::vector<int>> kCases[] = {
      {"-Y 3 +X 2", {0, 1, 2, 3, 4, 5}}, {"-Y 3 -X 2", {1, 0, 3, 2, 5, 4}},
      {"+Y 3 +X 2", {4, 5, 2, 3, 0, 1}}, {"+Y 3 -X 2", {5, 4, 3, 2, 1, 0}},
      {"+X 2 -Y 3", {0, 2, 4, 1, 3, 5}}, {"+X 2 +Y 3", {4, 2, 0, 5, 3, 1}},
      {"-X 2 -Y 3", {1, 3, 5, 0, 2, 4}}, {"-X 2 +Y 3", {5, 3, 1, 4, 2, 0}}};
  for (const auto& [resolution, order] : kCases) {
    std::string pixels;
    for (const int number : order) pixels += {char(number), 0, 0, char(136)};
    const Image image = ReadImage(Put("a.hdr", RgbeFile(resolution, pixels)));
    ASSERT_EQ(image.width, 2) << resolution;
    ASSERT_EQ(image.height, 3) << resolution;
    for (int i = 0; i < 6; ++i) EXPECT_EQ(image.rgb[i * 3], i) << resolution;
  }
}

TEST_F(ImageFiles, RgbeOfTheOldRunLengthCoding) {
  // The line holds pixel 5, three more of it, pixel 7, and 0x104 more with a count of two bytes,
  // the lowest first.
  const std::string pixels{
      "\x05\0\0\x88\x01\x01\x01\x03\x07\0\0\x88\x01\x01\x01\x04\x01\x01\x01\x01", 20};
  const Image image = ReadImage(Put("a.hdr", RgbeFile("-Y 1 +X 265", pixels)));
  for (int x = 0; x < 265; ++x) EXPECT_EQ(image.Pixel(x, 0)[0], x < 4 ? 5 : 7);
}

}  // namespace
}  // namespace skywave
