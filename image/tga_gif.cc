#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "base/error.h"
#include "image/byte_cursor.h"
#include "image/formats.h"

// stb_image decodes both. It is compiled here, and nobody else sees its names.
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_TGA
#define STBI_ONLY_GIF
#define STBI_NO_STDIO
#define STBI_FAILURE_USERMSG
#define STBI_ASSERT(condition) static_cast<void>(condition)
#define STBI_MAX_DIMENSIONS 32768
#include <stb/stb_image.h>

namespace skywave {
namespace {

static_assert(ReadLimits{}.max_width <= STBI_MAX_DIMENSIONS &&
              ReadLimits{}.max_height <= STBI_MAX_DIMENSIONS);

// Where a file ends early, stb_image takes zeros or whatever was in memory. So the bytes are handed
// to it piece by piece, which shows whether it needed more than there are.
struct Source {
  std::string_view left;
  const char* ahead = nullptr;  // where stb_image reads ahead to, more than it may need
  bool ended = false;           // bytes were needed beyond the end
};

int ReadSource(void* user, char* to, int size) {
  Source& source = *static_cast<Source*>(user);
  if (!source.ahead) source.ahead = to;  // every decoder begins so
  const std::size_t count = std::min(source.left.size(), std::size_t(std::max(size, 0)));
  std::copy_n(source.left.data(), count, to);
  source.left.remove_prefix(count);
  if (count == 0 || (count < std::size_t(size) && to != source.ahead)) source.ended = true;
  return int(count);
}

void SkipSource(void* user, int count) {
  Source& source = *static_cast<Source*>(user);
  source.left.remove_prefix(std::min(source.left.size(), std::size_t(std::max(count, 0))));
}

int IsSourceAtEnd(void* user) { return static_cast<Source*>(user)->left.empty(); }

// Takes rows from the right where `from_right` says so, which stb_image ignores.
CompactImage DecodeByStb(const char* format, std::int64_t width, std::int64_t height,
                         const std::string& path, std::string_view bytes, Encoding encoding,
                         const ReadLimits& limits, bool from_right = false) {
  CheckSize(InputPosition::File(path), width, height, limits);
  constexpr stbi_io_callbacks kCallbacks = {ReadSource, SkipSource, IsSourceAtEnd};
  constexpr int kRgba = 4;
  Source source{bytes};
  int columns = 0, rows = 0, channels = 0;
  const std::unique_ptr<std::uint8_t, void (*)(void*)> rgba(
      stbi_load_from_callbacks(&kCallbacks, &source, &columns, &rows, &channels, kRgba),
      stbi_image_free);
  const auto fail = [&](const char* reason) {
    throw InputError(InputPosition::File(path),
                     std::string("is no ") + format + " to read: " + reason);
  };
  if (source.ended) fail("the file ends within the picture");
  if (!rgba) fail(stbi_failure_reason());
  if (columns != width || rows != height) fail("its header is that of another format");
  const auto pixel = [&](int x, int y) {
    return rgba.get() + kRgba * (std::size_t(y) * std::size_t(columns) + std::size_t(x));
  };
  for (int y = 0; from_right && y < rows; ++y) {
    for (int x = 0; x < columns / 2; ++x) {
      std::swap_ranges(pixel(x, y), pixel(x, y) + kRgba, pixel(columns - 1 - x, y));
    }
  }
  return FromRgba(columns, rows, rgba.get(), encoding);
}

// stb_image reads palettes that begin at colour 0, of pictures that use them. Returns the same
// picture so: without a palette that nothing uses, and with black for the colours before the first.
// Nothing if it is so already.
std::optional<std::string> WithPlainPalette(const std::string& path, std::string_view bytes) {
  constexpr std::size_t kHeader = 18, kFirst = 3;  // size, and offset of what tells the palette
  constexpr std::uint8_t kIndexed = 1, kIndexedRuns = 9;
  ByteCursor cursor(path, bytes);
  const std::size_t name = cursor.U8("the header");
  const bool has_palette = cursor.U8("the header") == 1;
  const std::uint8_t type = cursor.U8("the header");
  const bool uses_it = type == kIndexed || type == kIndexedRuns;
  const std::size_t first = cursor.U16("the header"), count = cursor.U16("the header"),
                    entry = (std::size_t{cursor.U8("the header")} + 7) / 8;
  if (!has_palette || (uses_it && first == 0)) return std::nullopt;
  std::string plain(bytes);
  const std::size_t begin = kHeader + name;
  if (bytes.size() < begin + count * entry) cursor.Fail("the file ends within the palette");
  if (!uses_it) {
    plain.erase(begin, count * entry);
    plain[1] = 0;
    plain.replace(kFirst, 5, 5, '\0');
    return plain;
  }
  if (first + count > 0xFFFF) cursor.Fail("a palette of more than 65535 colours");
  plain.insert(begin, first * entry, '\0');
  const std::size_t all = first + count;
  plain[kFirst] = plain[kFirst + 1] = 0;
  plain[kFirst + 2] = char(all & 0xFF), plain[kFirst + 3] = char(all >> 8);
  return plain;
}

}  // namespace

CompactImage DecodeTga(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits) {
  constexpr std::size_t kSize = 12;        // offset of the width [bytes]
  constexpr std::uint8_t kFromRight = 16;  // a bit of the last byte of the header
  ByteCursor cursor(path, bytes);
  cursor.Take(kSize, "the header");
  const std::int64_t width = cursor.U16("the header"), height = cursor.U16("the header");
  cursor.Take(1, "the header");
  const bool from_right = (cursor.U8("the header") & kFromRight) != 0;
  const std::optional<std::string> plain = WithPlainPalette(path, bytes);
  return DecodeByStb("TGA", width, height, path, plain ? *plain : bytes, encoding, limits,
                     from_right);
}

CompactImage DecodeGif(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits) {
  constexpr std::size_t kSize = 6;  // offset of the width [bytes]
  ByteCursor cursor(path, bytes);
  cursor.Take(kSize, "the header");
  const std::int64_t width = cursor.U16("the header"), height = cursor.U16("the header");
  return DecodeByStb("GIF", width, height, path, bytes, encoding, limits);
}

}  // namespace skywave
