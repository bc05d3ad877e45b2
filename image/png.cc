#include <png.h>
#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "base/error.h"
#include "base/files.h"
#include "image/formats.h"
#include "image/image.h"

namespace skywave {

namespace {

std::string BigEndian(unsigned value) {
  return {char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
}

void AppendChunk(const std::string& type, const std::string& data, std::string& png) {
  const std::string body = type + data;
  png += BigEndian(unsigned(data.size())) + body;
  png += BigEndian(unsigned(
      crc32(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(body.data()), uInt(body.size()))));
}

// The predictor of PNG's filter 4: the neighbour left, above or left above that is nearest to
// left + above - left above.
int Paeth(int left, int above, int corner) {
  const int to_left = std::abs(above - corner), to_above = std::abs(left - corner);
  const int to_corner = std::abs(left + above - 2 * corner);
  if (to_left <= to_above && to_left <= to_corner) return left;
  return to_above <= to_corner ? above : corner;
}

// Returns the rows [first, last), each as the differences by the filter for which the sum of their
// sizes is least, after the number of that filter.
std::vector<std::uint8_t> FilteredRows(int width, int first, int last, std::size_t pixel,
                                       const std::uint8_t* pixels) {
  const std::size_t bytes = std::size_t(width) * pixel;
  const std::vector<std::uint8_t> black(bytes);
  std::vector<std::uint8_t> filtered, candidate(bytes), best(bytes);
  filtered.reserve((bytes + 1) * std::size_t(last - first));
  for (int y = first; y < last; ++y) {
    const std::uint8_t* const row = pixels + std::size_t(y) * bytes;
    const std::uint8_t* const above = y > 0 ? row - bytes : black.data();
    long least = -1;
    std::uint8_t best_filter = 0;
    const auto attempt = [&](std::uint8_t filter, const auto& predict) {
      long sum = 0;
      for (std::size_t i = 0; i < bytes; ++i) {
        const bool inside = i >= pixel;
        const int left = inside ? row[i - pixel] : 0, corner = inside ? above[i - pixel] : 0;
        candidate[i] = std::uint8_t(row[i] - predict(left, int(above[i]), corner));
        sum += std::abs(int(std::int8_t(candidate[i])));
      }
      if (least >= 0 && sum >= least) return;
      least = sum, best_filter = filter;
      best.swap(candidate);
    };
    attempt(1, [](int left, int, int) { return left; });
    attempt(2, [](int, int up, int) { return up; });
    attempt(4, Paeth);
    filtered.push_back(best_filter);
    filtered.insert(filtered.end(), best.begin(), best.end());
  }
  return filtered;
}

// A part of a stream of zlib, without the header and checksum of the whole.
struct PngBand {
  std::string bytes;
  std::size_t size = 0;  // before it was compressed
  uLong adler = 0;       // checksum of what was compressed
};

PngBand Deflated(const std::vector<std::uint8_t>& filtered, bool is_last) {
  constexpr int kLevel = 4, kNoHeader = -15, kMemory = 9;
  z_stream stream = {};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kNoHeader, kMemory, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
  PngBand band = {.bytes = {},
                  .size = filtered.size(),
                  .adler = adler32(adler32(0, nullptr, 0), filtered.data(), uInt(filtered.size()))};
  constexpr std::size_t kMarker = 16;  // the empty block at the end
  band.bytes.resize(deflateBound(&stream, uLong(filtered.size())) + kMarker);
  stream.next_in = const_cast<Bytef*>(filtered.data());
  stream.avail_in = uInt(filtered.size());
  stream.next_out = reinterpret_cast<Bytef*>(band.bytes.data());
  stream.avail_out = uInt(band.bytes.size());
  deflate(&stream, is_last ? Z_FINISH : Z_SYNC_FLUSH);
  band.bytes.resize(stream.total_out);
  deflateEnd(&stream);
  return band;
}

// What reading has in hand. libpng leaves its functions by longjmp after an error, so this holds
// what has to survive that.
struct PngReading {
  std::string_view left;
  png_structp png = nullptr;
  png_infop info = nullptr;
  char message[128] = "";
};

void FailPng(png_structp png, png_const_charp message) {
  auto* const reading = static_cast<PngReading*>(png_get_error_ptr(png));
  std::snprintf(reading->message, sizeof reading->message, "%s", message);
  png_longjmp(png, 1);
}
void IgnoreWarning(png_structp, png_const_charp) {}

void TakeBytes(png_structp png, png_bytep to, std::size_t size) {
  auto& left = static_cast<PngReading*>(png_get_io_ptr(png))->left;
  if (size > left.size()) png_error(png, "the file ends within the picture");
  std::copy_n(left.data(), size, reinterpret_cast<char*>(to));
  left.remove_prefix(size);
}

// No object with a destructor may be created between setjmp and longjmp, so the two halves of
// reading are plain functions that return false on errors. The pixels become four numbers each, of
// 16 bits if the file has so many and of 8 bits otherwise. Whatever gamma the file gives is not
// applied: readers of textures (pbrt, glTF) take the numbers as sRGB or as they are.
bool ReadPngHeader(PngReading& reading, png_uint_32& width, png_uint_32& height, int& depth) {
  if (setjmp(png_jmpbuf(reading.png))) return false;
  png_set_read_fn(reading.png, &reading, TakeBytes);
  png_set_user_limits(reading.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // CheckSize has others
  png_read_info(reading.png, reading.info);
  width = png_get_image_width(reading.png, reading.info);
  height = png_get_image_height(reading.png, reading.info);
  depth = png_get_bit_depth(reading.png, reading.info) == 16 ? 16 : 8;
  return true;
}
bool ReadPngPixels(PngReading& reading, int depth, std::uint8_t* rows, std::size_t stride,
                   png_uint_32 height) {
  if (setjmp(png_jmpbuf(reading.png))) return false;
  png_set_expand(reading.png);  // palettes, fewer bits than 8, and transparent colours
  png_set_gray_to_rgb(reading.png);
  static_assert(std::endian::native == std::endian::little);
  if (depth == 16) png_set_swap(reading.png);
  png_set_add_alpha(reading.png, depth == 16 ? 0xFFFF : 0xFF, PNG_FILLER_AFTER);
  const int passes = png_set_interlace_handling(reading.png);
  png_read_update_info(reading.png, reading.info);
  for (int pass = 0; pass < passes; ++pass) {
    for (png_uint_32 y = 0; y < height; ++y) {
      png_read_row(reading.png, rows + stride * y, nullptr);
    }
  }
  return true;
}

}  // namespace

// The file is put together here, because libpng compresses in one go: bands of rows are compressed
// at the same time, each as blocks of deflate that end at a byte and go into an IDAT chunk of their
// own.
std::string EncodePng(int width, int height, const std::vector<std::uint8_t>& rgb,
                      const std::vector<std::uint8_t>& alpha) {
  assert(rgb.size() == std::size_t(width) * height * 3);
  assert(alpha.empty() || 3 * alpha.size() == rgb.size());
  std::vector<std::uint8_t> rgba;
  rgba.reserve(4 * alpha.size());
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    rgba.insert(rgba.end(), {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], alpha[i]});
  }
  const std::vector<std::uint8_t>& pixels = alpha.empty() ? rgb : rgba;
  const std::size_t pixel = alpha.empty() ? 3 : 4;
  if (width < 1 || height < 1) {
    throw InputError(InputPosition::File("PNG"), "a picture without pixels cannot be encoded",
                     kExitIo);
  }
  constexpr int kBandRows = 64;
  const int bands = (height + kBandRows - 1) / kBandRows;
  std::vector<PngBand> compressed;
  compressed.resize(std::size_t(bands));
  tbb::parallel_for(0, bands, [&](int band) {
    const int first = band * kBandRows, last = std::min(first + kBandRows, height);
    compressed[std::size_t(band)] =
        Deflated(FilteredRows(width, first, last, pixel, pixels.data()), band + 1 == bands);
  });
  std::string png("\x89PNG\r\n\x1a\n", 8);
  // Eight bits for each of red, green, blue and alpha; no interlacing.
  const char kind = alpha.empty() ? 2 : 6;
  AppendChunk(
      "IHDR",
      BigEndian(unsigned(width)) + BigEndian(unsigned(height)) + std::string{8, kind, 0, 0, 0},
      png);
  AppendChunk("sRGB", std::string(1, '\0'), png);
  uLong sum = adler32(0, nullptr, 0);
  for (std::size_t band = 0; band < compressed.size(); ++band) {
    sum = adler32_combine(sum, compressed[band].adler, z_off_t(compressed[band].size));
    // The stream begins with the header of zlib and ends with the checksum of all that it holds.
    std::string data = band == 0 ? "\x78\x01" : "";
    data += compressed[band].bytes;
    if (band + 1 == compressed.size()) data += BigEndian(unsigned(sum));
    AppendChunk("IDAT", data, png);
  }
  AppendChunk("IEND", "", png);
  return png;
}

void WritePng(const std::string& path, int width, int height,
              const std::vector<std::uint8_t>& rgb) {
  WriteFileAtomically(path, EncodePng(width, height, rgb));
}

CompactImage DecodePng(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits) {
  PngReading reading{bytes};
  struct Free {
    PngReading* reading;
    ~Free() { png_destroy_read_struct(&reading->png, &reading->info, nullptr); }
  } const free_at_end{&reading};
  const auto fail = [&] {
    throw InputError(InputPosition::File(path),
                     std::string("is no PNG to read: ") + reading.message);
  };
  reading.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, FailPng, IgnoreWarning);
  if (reading.png == nullptr) throw std::bad_alloc();
  reading.info = png_create_info_struct(reading.png);
  if (reading.info == nullptr) throw std::bad_alloc();
  png_uint_32 width = 0, height = 0;
  int depth = 8;
  if (!ReadPngHeader(reading, width, height, depth)) fail();
  CheckSize(InputPosition::File(path), width, height, limits);
  const std::size_t stride = std::size_t(width) * 4 * std::size_t(depth / 8);
  std::vector<std::uint8_t> rgba(stride * height);
  if (!ReadPngPixels(reading, depth, rgba.data(), stride, height)) fail();
  if (depth == 8) return FromRgba(int(width), int(height), rgba.data(), encoding);
  std::vector<std::uint16_t> deep(rgba.size() / 2);
  std::memcpy(deep.data(), rgba.data(), rgba.size());
  return FromDeepRgba(int(width), int(height), deep, encoding);
}

}  // namespace skywave
