#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "image/byte_cursor.h"
#include "image/formats.h"

namespace skywave {
namespace {

std::int64_t BigEndian32(ByteCursor& cursor) {
  std::int64_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | cursor.U8("the header");
  return value;
}

}  // namespace

// "The Quite OK Image Format", qoiformat.org, version 1.0: each chunk gives a pixel as a colour, as
// a place in a table of earlier ones, or as a difference to the last one, or repeats that.
CompactImage DecodeQoi(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits) {
  constexpr std::size_t kMagic = 4, kIndexed = 64;
  constexpr int kRgb = 0xfe, kRgba = 0xff;
  ByteCursor cursor(path, bytes);
  cursor.Take(kMagic, "the header");
  const std::int64_t width = BigEndian32(cursor), height = BigEndian32(cursor);
  CheckSize(InputPosition::File(path), width, height, limits);
  const int channels = cursor.U8("the header");
  if (channels != 3 && channels != 4) cursor.Fail("QOI has 3 or 4 channels");
  const int color_space = cursor.U8("the header");
  if (color_space > 1) cursor.Fail("QOI has the colour spaces 0 and 1");
  if (color_space == 1 && encoding == Encoding::kSrgb) encoding = Encoding::kLinear;

  using Rgba = std::array<std::uint8_t, 4>;
  std::array<Rgba, kIndexed> earlier = {};
  Rgba pixel = {0, 0, 0, 255};
  std::vector<std::uint8_t> rgba(std::size_t(width) * std::size_t(height) * 4);
  int repeated = 0;
  for (std::size_t at = 0; at < rgba.size(); at += 4) {
    if (repeated > 0) {
      --repeated;
    } else if (const int tag = cursor.U8("the pixels"); tag == kRgb || tag == kRgba) {
      for (int c = 0; c < (tag == kRgb ? 3 : 4); ++c) pixel[c] = cursor.U8("the pixels");
    } else if (const int low = tag & 63; tag < 64) {
      pixel = earlier[low];
    } else if (tag < 128) {
      for (int c = 0; c < 3; ++c) pixel[c] += std::uint8_t((low >> (4 - 2 * c) & 3) - 2);
    } else if (tag < 192) {
      const int others = cursor.U8("the pixels"), green = low - 32;
      pixel[0] += std::uint8_t(green + (others >> 4) - 8);
      pixel[1] += std::uint8_t(green);
      pixel[2] += std::uint8_t(green + (others & 15) - 8);
    } else {
      repeated = low;
    }
    earlier[(pixel[0] * 3u + pixel[1] * 5u + pixel[2] * 7u + pixel[3] * 11u) % kIndexed] = pixel;
    std::copy(pixel.begin(), pixel.end(), &rgba[at]);
  }
  return FromRgba(int(width), int(height), rgba.data(), encoding);
}

}  // namespace skywave
