// Reads and writes portable float maps: "PF" (colour) or "Pf" (grey), width, height and scale as
// text, one white space, then raw floats, rows from the bottom.
//
// The sign of the scale gives the byte order (negative: little-endian), its magnitude a factor of
// the values, which is 1 in most files; pbrt-v4 multiplies by it, too. Words may have any white
// space and lines of comments (#) before them.

#include <bit>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstring>

#include "base/files.h"
#include "image/byte_cursor.h"
#include "image/formats.h"

namespace skywave {
namespace {

static_assert(std::endian::native == std::endian::little, "files are read and written as such");

constexpr std::size_t kMaxPfmHeaderBytes = 4096;

bool IsSpace(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

// Returns the next word of the header and skips exactly one white space after it: more would
// consume pixels.
std::string_view TakeWord(ByteCursor& cursor, std::string_view bytes) {
  const auto at = [&](std::size_t i) {
    if (i >= kMaxPfmHeaderBytes) cursor.Fail("the PFM header has no end");
    return i < bytes.size() ? bytes[i] : ' ';
  };
  std::size_t start = cursor.offset();
  bool in_comment = false;
  for (; start < bytes.size() && (in_comment || IsSpace(at(start)) || at(start) == '#'); ++start) {
    in_comment = (in_comment || at(start) == '#') && at(start) != '\n';
  }
  std::size_t end = start;
  while (!IsSpace(at(end))) ++end;
  cursor.Take(end + 1 - cursor.offset(), "the PFM header");
  return bytes.substr(start, end - start);
}

float FromBigEndian(float value) {
  return std::bit_cast<float>(__builtin_bswap32(std::bit_cast<std::uint32_t>(value)));
}

}  // namespace

Image DecodePfm(const std::string& path, std::string_view bytes, const ReadLimits& limits) {
  ByteCursor cursor(path, bytes);
  const std::string_view magic = TakeWord(cursor, bytes);
  if (magic != "PF" && magic != "Pf") cursor.Fail("is not a PFM: it starts with neither PF nor Pf");
  const int channels = magic == "PF" ? 3 : 1;

  const InputPosition size_position = InputPosition::Byte(path, cursor.offset());
  const std::int64_t width = ParseSize(TakeWord(cursor, bytes));
  const std::int64_t height = ParseSize(TakeWord(cursor, bytes));
  if (width < 0 || height < 0)
    throw InputError(size_position, "the PFM size is not two plain numbers");
  CheckSize(size_position, width, height, limits);

  const InputPosition scale_position = InputPosition::Byte(path, cursor.offset());
  std::string_view scale_text = TakeWord(cursor, bytes);
  if (scale_text.starts_with('+')) scale_text.remove_prefix(1);
  const char* const scale_end = scale_text.data() + scale_text.size();
  double scale = 0;
  const auto [parsed_to, error] = std::from_chars(scale_text.data(), scale_end, scale);
  if (error != std::errc() || parsed_to != scale_end || !std::isfinite(scale) || scale == 0) {
    throw InputError(scale_position, "the PFM scale must be a finite number other than 0");
  }

  const std::size_t row_bytes = std::size_t(width) * channels * sizeof(float);
  const std::size_t expected = row_bytes * height;
  const auto factor = float(std::abs(scale));
  if (cursor.left() == expected + 1 && bytes[cursor.offset()] == '\n') {
    cursor.Take(1, "the PFM header");  // lines that end by two characters
  }
  if (cursor.left() != expected) {
    cursor.Fail("the PFM size asks for " + std::to_string(expected) +
                " bytes of pixels, the file has " + std::to_string(cursor.left()));
  }
  Image image{int(width), int(height)};
  std::vector<float> row(std::size_t(width) * channels);
  for (int y = image.height; y-- > 0;) {
    std::memcpy(row.data(), cursor.Take(row_bytes, "the pixels").data(), row_bytes);
    for (std::size_t i = 0; i < row.size(); ++i) {
      const float stored = scale > 0 ? FromBigEndian(row[i]) : row[i];
      const float value = factor == 1 ? stored : factor * stored;  // NaN keeps its bits
      float* const pixel = image.Pixel(0, y) + i * 3 / channels;
      std::fill_n(pixel, 3 / channels, value);
    }
  }
  return image;
}

void WritePfm(const std::string& path, const Image& image) {
  assert(image.rgb.size() == std::size_t(image.width) * image.height * 3);
  std::string bytes =
      "PF\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n-1.0\n";
  const std::size_t row_bytes = std::size_t(image.width) * 3 * sizeof(float);
  bytes.reserve(bytes.size() + row_bytes * image.height);
  for (int y = image.height; y-- > 0;) {
    bytes.append(reinterpret_cast<const char*>(image.Pixel(0, y)), row_bytes);
  }
  WriteFileAtomically(path, bytes);
}

}  // namespace skywave
