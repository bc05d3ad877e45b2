#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>

#include "base/error.h"
#include "image/byte_cursor.h"
#include "image/formats.h"

// stb_image decodes all three. It is compiled here, and nobody else sees its names.
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_TGA
#define STBI_ONLY_BMP
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

Image DecodeByStb(const char* format, std::int64_t width, std::int64_t height,
                  const std::string& path, std::string_view bytes, Encoding encoding,
                  const ReadLimits& limits) {
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
  return FromRgba(columns, rows, rgba.get(), encoding);
}

std::int64_t U16(ByteCursor& cursor) {
  const std::int64_t low = cursor.U8("the header");
  return low | std::int64_t(cursor.U8("the header")) << 8;
}

}  // namespace

Image DecodeTga(const std::string& path, std::string_view bytes, Encoding encoding,
                const ReadLimits& limits) {
  constexpr std::size_t kSize = 12;  // offset of the width [bytes]
  ByteCursor cursor(path, bytes);
  cursor.Take(kSize, "the header");
  const std::int64_t width = U16(cursor), height = U16(cursor);
  return DecodeByStb("TGA", width, height, path, bytes, encoding, limits);
}

// The rows of a BMP go from the bottom if the height is positive. Its oldest headers, of 12 bytes,
// have short sizes.
Image DecodeBmp(const std::string& path, std::string_view bytes, Encoding encoding,
                const ReadLimits& limits) {
  constexpr std::size_t kHeader = 14;
  constexpr std::uint32_t kOldest = 12;
  ByteCursor cursor(path, bytes);
  cursor.Take(kHeader, "the header");
  const bool oldest = cursor.U32("the header") == kOldest;
  const std::int64_t width = oldest ? U16(cursor) : cursor.I32("the header");
  const std::int64_t height = oldest ? U16(cursor) : cursor.I32("the header");
  return DecodeByStb("BMP", width, std::abs(height), path, bytes, encoding, limits);
}

Image DecodeGif(const std::string& path, std::string_view bytes, Encoding encoding,
                const ReadLimits& limits) {
  constexpr std::size_t kSize = 6;  // offset of the width [bytes]
  ByteCursor cursor(path, bytes);
  cursor.Take(kSize, "the header");
  const std::int64_t width = U16(cursor), height = U16(cursor);
  return DecodeByStb("GIF", width, height, path, bytes, encoding, limits);
}

}  // namespace skywave
