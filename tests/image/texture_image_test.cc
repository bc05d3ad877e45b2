// Reads PNG and JPEG pictures as textures, valid and damaged ones.
#include <gtest/gtest.h>

#include <cstdio>
// jpeglib.h needs FILE from this header.
#include <jpeglib.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "tests/support/deep_png.h"

namespace skywave {
namespace {

std::vector<std::uint8_t> Pixels(int width, int height) {
  std::vector<std::uint8_t> rgb(std::size_t(width) * height * 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::uint8_t* const p = &rgb[(std::size_t(y) * width + x) * 3];
      p[0] = std::uint8_t(255 * x / std::max(width - 1, 1));
      p[1] = std::uint8_t(255 * y / std::max(height - 1, 1)), p[2] = 128;
    }
  }
  return rgb;
}

std::string EncodeJpeg(int width, int height, const std::vector<std::uint8_t>& rgb,
                       bool progressive, int channels = 3) {
  jpeg_compress_struct encoder = {};
  jpeg_error_mgr errors = {};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &memory, &size);
  encoder.image_width = JDIMENSION(width), encoder.image_height = JDIMENSION(height);
  encoder.input_components = channels;
  encoder.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 4 ? JCS_CMYK : JCS_RGB;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, 98, TRUE);
  if (progressive) jpeg_simple_progression(&encoder);
  jpeg_start_compress(&encoder, TRUE);
  while (encoder.next_scanline < encoder.image_height) {
    auto* row = const_cast<JSAMPROW>(&rgb[std::size_t(encoder.next_scanline) * width * channels]);
    jpeg_write_scanlines(&encoder, &row, 1);
  }
  jpeg_finish_compress(&encoder);
  jpeg_destroy_compress(&encoder);
  const std::string bytes(reinterpret_cast<char*>(memory), size);
  std::free(memory);
  return bytes;
}

double Linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

TEST(TextureImages, PngIsExactInBothEncodings) {
  const auto rgb = Pixels(19, 7);
  const std::string png = EncodePng(19, 7, rgb);
  const Image color = DecodeTexture("a.png", png, Encoding::kSrgb);
  const Image number = DecodeTexture("a.png", png, Encoding::kLinear);
  ASSERT_EQ(color.width, 19);
  ASSERT_EQ(color.height, 7);
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    ASSERT_FLOAT_EQ(color.rgb[i], float(Linear(rgb[i] / 255.0)));
    ASSERT_FLOAT_EQ(number.rgb[i], rgb[i] / 255.0f);
  }
}

// Two bytes a channel mean what one byte does: the texels of a file of 16 bits whose low bytes
// repeat the high ones are those of 8 bits.
TEST(TextureImages, PngOfSixteenBitsIsEncodedLikeThatOfEight) {
  const int width = 19, height = 7;
  const auto rgb = Pixels(width, height);
  std::vector<std::uint16_t> wide(rgb.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) wide[i] = std::uint16_t(257 * rgb[i]);
  const std::string png = DeepPng(width, height, PNG_INTERLACE_NONE, wide);
  const Image color = DecodeTexture("a.png", png, Encoding::kSrgb);
  const Image number = DecodeTexture("a.png", png, Encoding::kLinear);
  ASSERT_EQ(color.rgb.size(), rgb.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    ASSERT_FLOAT_EQ(color.rgb[i], float(Linear(rgb[i] / 255.0)));
    ASSERT_FLOAT_EQ(number.rgb[i], rgb[i] / 255.0f);
  }
}

// A file may say that its numbers are linear light; those of textures are not.
TEST(TextureImages, PngIsTheSameWithAGammaOfItsOwn) {
  const auto rgb = Pixels(19, 7);
  const std::string plain = EncodePng(19, 7, rgb);
  // The length, 100000 (a gamma of 1), and their CRC as libpng has it come after IHDR.
  const std::string gamma("\0\0\0\4gAMA\0\1\x86\xa0\x31\xe8\x96\x5f", 16);
  const std::size_t behind = plain.find("sRGB") - 4;
  std::string png = plain.substr(0, behind) + gamma + plain.substr(behind + 13);
  for (const Encoding encoding : {Encoding::kSrgb, Encoding::kLinear}) {
    EXPECT_EQ(DecodeTexture("a.png", png, encoding).rgb,
              DecodeTexture("a.png", plain, encoding).rgb);
  }
  // The last 16 bytes, the check sum and IEND, do not affect the pixels.
  for (std::size_t size = 0; size < png.size() - 16; ++size) {
    EXPECT_THROW(DecodeTexture("a.png", png.substr(0, size), Encoding::kSrgb), InputError) << size;
  }
}

TEST(TextureImages, JpegIsCloseBaselineAndProgressiveAndGrey) {
  const auto rgb = Pixels(40, 24);
  for (const bool progressive : {false, true}) {
    const Image image =
        DecodeTexture("a.jpg", EncodeJpeg(40, 24, rgb, progressive), Encoding::kLinear);
    ASSERT_EQ(image.width, 40);
    ASSERT_EQ(image.height, 24);
    for (std::size_t i = 0; i < rgb.size(); ++i) {
      ASSERT_NEAR(image.rgb[i], rgb[i] / 255.0, 0.06) << i;
    }
  }
  const std::vector<std::uint8_t> grey(16 * 8, 77);
  const Image image = DecodeTexture("g.jpg", EncodeJpeg(16, 8, grey, false, 1), Encoding::kLinear);
  for (const float value : image.rgb) ASSERT_NEAR(value, 77 / 255.0, 0.005);
  EXPECT_THROW(DecodeTexture("c.jpg", EncodeJpeg(4, 4, std::vector<std::uint8_t>(64), false, 4),
                             Encoding::kLinear),
               InputError);
}

TEST(TextureImages, EveryPrefixIsRefused) {
  const auto rgb = Pixels(17, 9);
  for (const std::string& file :
       {EncodeJpeg(17, 9, rgb, false), EncodeJpeg(17, 9, rgb, true), EncodePng(17, 9, rgb)}) {
    EXPECT_NO_THROW(DecodeTexture("a", file, Encoding::kSrgb));
    // The last 16 bytes of a PNG, the check sum and IEND, do not affect its pixels.
    const std::size_t end = file[0] == '\x89' ? file.size() - 16 : file.size() - 1;
    for (std::size_t length = 0; length < end; ++length) {
      EXPECT_THROW(DecodeTexture("a", std::string_view(file).substr(0, length), Encoding::kSrgb),
                   InputError)
          << length << " of " << file.size();
    }
  }
}

TEST(TextureImages, EveryFlippedBitIsSurvived) {
  const auto rgb = Pixels(17, 9);
  ReadLimits limits;
  limits.max_pixels = 1 << 16;
  int refused = 0;
  for (const std::string& file :
       {EncodeJpeg(17, 9, rgb, false), EncodeJpeg(17, 9, rgb, true), EncodePng(17, 9, rgb)}) {
    for (std::size_t bit = 0; bit < file.size() * 8; ++bit) {
      std::string damaged = file;
      damaged[bit / 8] = char(damaged[bit / 8] ^ (1 << bit % 8));
      try {
        const Image image = DecodeTexture("a", damaged, Encoding::kSrgb, limits);
        EXPECT_EQ(image.rgb.size(), std::size_t(image.width) * image.height * 3);
      } catch (const InputError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(TextureImages, LimitsHoldBeforeAnythingIsDecoded) {
  ReadLimits narrow;
  narrow.max_width = 16;
  const auto rgb = Pixels(17, 9);
  for (const std::string& file : {EncodeJpeg(17, 9, rgb, false), EncodePng(17, 9, rgb)}) {
    try {
      DecodeTexture("a", file, Encoding::kSrgb, narrow);
      ADD_FAILURE();
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("limit"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace skywave
