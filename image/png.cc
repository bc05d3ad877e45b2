#include <png.h>
#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <cassert>
#include <cstdlib>
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
std::vector<std::uint8_t> FilteredRows(int width, int first, int last, const std::uint8_t* rgb) {
  constexpr std::size_t kPixel = 3;
  const std::size_t bytes = std::size_t(width) * kPixel;
  const std::vector<std::uint8_t> black(bytes);
  std::vector<std::uint8_t> filtered, candidate(bytes), best(bytes);
  filtered.reserve((bytes + 1) * std::size_t(last - first));
  for (int y = first; y < last; ++y) {
    const std::uint8_t* const row = rgb + std::size_t(y) * bytes;
    const std::uint8_t* const above = y > 0 ? row - bytes : black.data();
    long least = -1;
    std::uint8_t best_filter = 0;
    const auto attempt = [&](std::uint8_t filter, const auto& predict) {
      long sum = 0;
      for (std::size_t i = 0; i < bytes; ++i) {
        const bool inside = i >= kPixel;
        const int left = inside ? row[i - kPixel] : 0, corner = inside ? above[i - kPixel] : 0;
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

// Returns the file without its chunks gAMA, which libpng's simplified interface would apply:
// readers of textures (pbrt, glTF) take the numbers of the file as sRGB or as they are, whatever
// gamma the file gives. Anything that is no list of chunks stays as it is.
std::string WithoutGamma(std::string_view bytes) {
  constexpr std::size_t kSignature = 8, kFrame = 12;  // length, type and checksum of a chunk
  std::string kept(bytes.substr(0, kSignature));
  std::size_t at = kept.size();
  while (bytes.size() - at >= kFrame) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | std::uint8_t(bytes[at + i]);
    if (length > bytes.size() - at - kFrame) break;
    const std::string_view chunk = bytes.substr(at, length + kFrame);
    if (chunk.substr(4, 4) != "gAMA") kept += chunk;
    at += chunk.size();
  }
  return kept += bytes.substr(at);
}

}  // namespace

// The file is put together here, because libpng compresses in one go: bands of rows are compressed
// at the same time, each as blocks of deflate that end at a byte and go into an IDAT chunk of their
// own.
std::string EncodePng(int width, int height, const std::vector<std::uint8_t>& rgb) {
  assert(rgb.size() == std::size_t(width) * height * 3);
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
        Deflated(FilteredRows(width, first, last, rgb.data()), band + 1 == bands);
  });
  std::string png("\x89PNG\r\n\x1a\n", 8);
  // Eight bits for each of red, green and blue; no interlacing.
  AppendChunk(
      "IHDR",
      BigEndian(unsigned(width)) + BigEndian(unsigned(height)) + std::string("\x08\x02\0\0\0", 5),
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

// libpng's simplified interface reports errors by return value instead of longjmp. It removes
// alpha by blending, so alpha is read and then dropped, or is the
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
  // The chunk stands before the pixels, and most files have none.
  std::string kept;
  if (bytes.substr(0, bytes.find("IDAT")).find("gAMA") != std::string_view::npos) {
    kept = WithoutGamma(bytes);
    bytes = kept;
  }
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) fail();
  CheckSize(InputPosition::File(path), png.width, png.height, limits);
  // Without this, 16-bit files that do not name their encoding are taken as linear light.
  png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
  png.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> rgba(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, nullptr, rgba.data(), 0, nullptr)) fail();
  return FromRgba(int(png.width), int(png.height), rgba.data(), encoding);
}

}  // namespace skywave
