// PNG of 16 bits, which EncodePng does not write.
#pragma once

#include <png.h>

#include <cstdint>
#include <string>
#include <vector>

namespace skywave {

// Returns a PNG of three channels of 16 bits, without a word about their encoding. `interlace` is
// PNG_INTERLACE_NONE or PNG_INTERLACE_ADAM7.
inline std::string DeepPng(int width, int height, int interlace,
                           const std::vector<std::uint16_t>& rgb) {
  std::string png;
  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(writer);
  png_set_write_fn(
      writer, &png,
      [](png_structp to, png_bytep bytes, std::size_t size) {
        static_cast<std::string*>(png_get_io_ptr(to))
            ->append(reinterpret_cast<const char*>(bytes), size);
      },
      nullptr);
  png_set_IHDR(writer, info, png_uint_32(width), png_uint_32(height), 16, PNG_COLOR_TYPE_RGB,
               interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer, info);
  std::vector<png_byte> bytes;
  for (const std::uint16_t value : rgb) {
    bytes.push_back(png_byte(value >> 8)), bytes.push_back(png_byte(value & 255));
  }
  const int passes = png_set_interlace_handling(writer);
  for (int pass = 0; pass < passes; ++pass) {
    for (int y = 0; y < height; ++y) png_write_row(writer, &bytes[std::size_t(6 * width * y)]);
  }
  png_write_end(writer, info);
  png_destroy_write_struct(&writer, &info);
  return png;
}

}  // namespace skywave
