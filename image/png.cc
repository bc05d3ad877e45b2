#include <png.h>

#include <algorithm>
#include <cassert>

#include "base/error.h"
#include "base/files.h"
#include "image/formats.h"
#include "image/image.h"

namespace skywave {

// libpng's simplified interface reports errors by return value instead of longjmp, marks the
// picture as sRGB and writes no time stamp.
std::string EncodePng(int width, int height, const std::vector<std::uint8_t>& rgb) {
  assert(rgb.size() == std::size_t(width) * height * 3);
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  png.width = png_uint_32(width);
  png.height = png_uint_32(height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  constexpr int kNotFrom16Bit = 0;
  constexpr int kRowsArePacked = 0;
  if (!png_image_write_to_memory(&png, bytes.data(), &size, kNotFrom16Bit, rgb.data(),
                                 kRowsArePacked, nullptr)) {
    throw InputError(InputPosition::File("PNG"),
                     std::string("the picture cannot be encoded: ") + png.message, kExitIo);
  }
  bytes.resize(size);
  return bytes;
}

void WritePng(const std::string& path, int width, int height,
              const std::vector<std::uint8_t>& rgb) {
  WriteFileAtomically(path, EncodePng(width, height, rgb));
}

// The simplified interface removes alpha by blending, so alpha is read and then dropped, or is the
// only channel that is kept.
Image DecodePng(const std::string& path, std::string_view bytes, Encoding encoding,
                const ReadLimits& limits) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  struct Free {
    png_image* image;
    ~Free() { png_image_free(image); }
  } const free_at_end{&png};
  const auto fail = [&] {
    throw InputError(InputPosition::File(path), std::string("is no PNG to read: ") + png.message);
  };
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) fail();
  CheckSize(InputPosition::File(path), png.width, png.height, limits);
  png.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> rgba(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, nullptr, rgba.data(), 0, nullptr)) fail();
  for (std::size_t i = 0; i < rgba.size() / 4; ++i) {
    if (encoding == Encoding::kAlpha) {
      std::fill_n(&rgba[3 * i], 3, rgba[4 * i + 3]);
    } else {
      std::copy_n(&rgba[4 * i], 3, &rgba[3 * i]);
    }
  }
  return FromBytes(int(png.width), int(png.height), rgba.data(), encoding);
}

}  // namespace skywave
