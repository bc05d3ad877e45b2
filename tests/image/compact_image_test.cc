// Tests images as scenes keep them: bytes of files stay bytes, and mean what floats would.
#include "image/compact_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "image/srgb.h"
#include "tests/support/deep_png.h"

namespace skywave {
namespace {

constexpr int kWidth = 16, kHeight = 16;

// All 256 codes in red, moved by channel.
std::vector<std::uint8_t> AllCodes() {
  std::vector<std::uint8_t> codes;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    for (int c = 0; c < 3; ++c) codes.push_back(std::uint8_t(i + 7 * c));
  }
  return codes;
}

TEST(CompactImage, BytesOfAFileStayBytesAndMeanWhatTheEncodingSays) {
  const std::vector<std::uint8_t> codes = AllCodes();
  const std::string png = EncodePng(kWidth, kHeight, codes);
  for (const Encoding encoding : {Encoding::kSrgb, Encoding::kLinear}) {
    const CompactImage image = DecodeCompactTexture("a.png", png, encoding);
    EXPECT_EQ(image.bytes(), codes.size());
    ASSERT_EQ(image.values(), codes.size());
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const double share = codes[i] / 255.0;
      EXPECT_FLOAT_EQ(image.Value(i),
                      float(encoding == Encoding::kSrgb ? LinearFromSrgb(share) : share));
    }
  }
}

TEST(CompactImage, AlphaIsANumberInAllChannels) {
  std::vector<std::uint8_t> alpha;
  for (int i = 0; i < kWidth * kHeight; ++i) alpha.push_back(std::uint8_t(i));
  const std::string png = EncodePng(kWidth, kHeight, AllCodes(), alpha);
  const CompactImage image = DecodeCompactTexture("a.png", png, Encoding::kAlpha);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    for (const float value : image.Pixel(i % kWidth, i / kWidth)) {
      EXPECT_FLOAT_EQ(value, float(i) / 255);
    }
  }
}

TEST(CompactImage, ValuesPixelsRowsAndFloatsAgreeInBothForms) {
  const CompactImage of_bytes(kWidth, kHeight, AllCodes(), Encoding::kSrgb);
  const CompactImage of_floats(of_bytes.Floats());
  EXPECT_EQ(of_floats.bytes(), 4 * of_bytes.bytes());
  for (const CompactImage* image : {&of_bytes, &of_floats}) {
    const Image floats = image->Floats();
    ASSERT_EQ(floats.width, kWidth);
    ASSERT_EQ(floats.height, kHeight);
    std::vector<float> decoded;
    for (int y = 0; y < kHeight; ++y) {
      const float* const row = image->Row(y, decoded);
      for (int x = 0; x < kWidth; ++x) {
        for (std::size_t c = 0; c < 3; ++c) {
          const float value = floats.Pixel(x, y)[c];
          EXPECT_EQ(value, of_bytes.Pixel(x, y)[c]);
          EXPECT_EQ(value, image->Pixel(x, y)[c]);
          EXPECT_EQ(value, image->Value(3 * std::size_t(y * kWidth + x) + c));
          EXPECT_EQ(value, row[3 * std::size_t(x) + c]);
        }
      }
    }
  }
}

TEST(CompactImage, SixteenBitsAreFloats) {
  const std::vector<std::uint16_t> rgb = {0, 1, 65535};
  const CompactImage image =
      DecodeCompactTexture("a.png", DeepPng(1, 1, false, rgb), Encoding::kLinear);
  EXPECT_EQ(image.bytes(), 3 * sizeof(float));
  EXPECT_FLOAT_EQ(image.Value(1), 1.0f / 65535);
}

TEST(CompactImage, WhatIsNoRadianceIsRepaired) {
  Image image(1, 1);
  image.rgb = {std::numeric_limits<float>::quiet_NaN(), -1, 2};
  CompactImage compact(image);
  compact.Repair();
  EXPECT_EQ(compact.Value(0), 0);
  EXPECT_EQ(compact.Value(1), 0);
  EXPECT_EQ(compact.Value(2), 2);
}

}  // namespace
}  // namespace skywave
