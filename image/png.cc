#include <png.h>

#include <cassert>

#include "base/error.h"
#include "base/files.h"
#include "image/image.h"

namespace skywave {

// libpng's simplified interface: it reports errors by return value instead of longjmp, marks the
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

}  // namespace skywave
