// Reads QOI textures that are written here after the specification (qoiformat.org, version 1.0).
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"

namespace skywave {
namespace {

std::string Header(int width, int height, int color_space = 0) {
  const auto big = [](int value) {
    return std::string{char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
  };
  return "qoif" + big(width) + big(height) + '\4' + char(color_space);
}
std::string Bytes(std::initializer_list<int> values) {
  std::string bytes;
  for (const int value : values) bytes += char(value);
  return bytes;
}

struct Chunk {
  std::string bytes;
  std::vector<int> rgba;  // of each pixel that it gives
  int pixels = 1;
};
const std::vector<Chunk> kEveryKind = {
    {Bytes({0xc0}), {0, 0, 0, 255}},                 // the last pixel; at first it is black
    {Bytes({0xfe, 10, 20, 30}), {10, 20, 30, 255}},  // a colour
    {Bytes({0x40 | 0b110001}), {11, 18, 29, 255}},   // + (1, -2, -1)
    {Bytes({0x80 | 42, 0x3c}), {16, 28, 43, 255}},   // green + 10, red + 10 - 5, blue + 10 + 4
    {Bytes({0xff, 200, 100, 50, 7}), {200, 100, 50, 7}},
    {Bytes({0xc0 | 2}), {200, 100, 50, 7}, 3},
    {Bytes({(10 * 3 + 20 * 5 + 30 * 7 + 255 * 11) % 64}), {10, 20, 30, 255}},  // an earlier one
    {Bytes({0x40 | 0b000000}), {8, 18, 28, 255}},
    {Bytes({0xfe, 0, 255, 1}), {0, 255, 1, 255}},
    {Bytes({0x40 | 0b001111}), {254, 0, 2, 255}},  // beyond the ends
};
std::string FileOfEveryKind() {
  std::string file = Header(4, 3);
  for (const Chunk& chunk : kEveryKind) file += chunk.bytes;
  return file;
}

TEST(Qoi, EveryKindOfChunkIsRead) {
  const std::string file = FileOfEveryKind() + Bytes({0, 0, 0, 0, 0, 0, 0, 1});
  const Image colors = DecodeTexture("a.qoi", file, Encoding::kLinear);
  const Image alpha = DecodeTexture("a", file, Encoding::kAlpha);
  ASSERT_EQ(colors.width, 4);
  ASSERT_EQ(colors.height, 3);
  std::size_t at = 0;
  for (const Chunk& chunk : kEveryKind) {
    for (std::size_t i = 0; i < 3 * std::size_t(chunk.pixels); ++i, ++at) {
      EXPECT_FLOAT_EQ(colors.rgb.at(at), float(chunk.rgba[i % 3] / 255.0)) << at;
      EXPECT_FLOAT_EQ(alpha.rgb.at(at), float(chunk.rgba[3] / 255.0)) << at;
    }
  }
  EXPECT_EQ(at, colors.rgb.size());
}

// The file says whether it has sRGB or linear light.
TEST(Qoi, ColorsAreOfTheSpaceOfTheFile) {
  const std::string grey = Bytes({0xfe, 128, 128, 128});
  EXPECT_NEAR(DecodeTexture("a", Header(1, 1, 0) + grey, Encoding::kSrgb).rgb[0], 0.2158605, 1e-6);
  EXPECT_NEAR(DecodeTexture("a", Header(1, 1, 1) + grey, Encoding::kSrgb).rgb[0], 128 / 255.0,
              1e-6);
}

TEST(Qoi, EveryPrefixAndImpossibleHeadersAreRefused) {
  const auto refused = [](const std::string& file, const ReadLimits& limits = {}) {
    try {
      DecodeTexture("a.qoi", file, Encoding::kSrgb, limits);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string file = FileOfEveryKind();
  EXPECT_EQ(refused(file), "");
  for (std::size_t length = 0; length < file.size(); ++length) {
    EXPECT_NE(refused(file.substr(0, length)), "") << length;
  }
  EXPECT_NE(refused(Header(70000, 70000)).find("limit"), std::string::npos);
  EXPECT_NE(refused(Header(-1, 4)).find("limit"), std::string::npos);
  EXPECT_NE(refused(file, {.max_width = 3}).find("limit"), std::string::npos);
  EXPECT_NE(refused(Header(0, 4)), "");
  EXPECT_EQ(refused(Header(1, 1, 1) + Bytes({0xc0})), "");
  EXPECT_NE(refused(Header(1, 1, 2) + Bytes({0xc0})), "");
}

}  // namespace
}  // namespace skywave
