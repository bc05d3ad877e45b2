#include "image/exr_strip.h"

#include <half.h>
#define ZLIB_CONST
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include "image/deflate.h"
#include "image/exr_header.h"

namespace skywave {
namespace {

// Higher levels of deflate take longer and make files of noise hardly smaller.
constexpr int kStripLevel = 1, kSmallLevel = 4;
// libdeflate 1.14 and 1.23 differ for chunks of up to 16 KiB, and versions of zlib do not. Chunks
// below this limit are therefore left to zlib, whose time does not matter there.
constexpr std::size_t kSmallChunk = std::size_t{1} << 16;
constexpr std::size_t kChunkStart = 8;  // [bytes] the first row of a chunk and its size

// Writes the bytes of a row of a channel, the even ones apart from the odd ones, as they are
// compressed.
void SplitRow(const float* values, std::size_t stride, bool is_half, std::size_t width,
              std::uint8_t* low, std::uint8_t* high) {
  if (is_half) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint16_t bits = HalfBits(values[x * stride]);
      low[x] = std::uint8_t(bits), high[x] = std::uint8_t(bits >> 8);
    }
    return;
  }
  for (std::size_t x = 0; x < width; ++x) {
    const auto bits = std::bit_cast<std::uint32_t>(values[x * stride]);
    low[2 * x] = std::uint8_t(bits), high[2 * x] = std::uint8_t(bits >> 8);
    low[2 * x + 1] = std::uint8_t(bits >> 16), high[2 * x + 1] = std::uint8_t(bits >> 24);
  }
}

// Writes the bytes of pixels in their order.
void Interleave(const std::uint8_t* low, const std::uint8_t* high, std::size_t pairs, char* out) {
  for (std::size_t i = 0; i < pairs; ++i) {
    out[2 * i] = char(low[i]), out[2 * i + 1] = char(high[i]);
  }
}

// Returns the compressed size of a chunk, whose bytes are written to `out`, or 0 if it is no
// smaller.
std::size_t DeflateChunk(Deflater& deflater, const std::uint8_t* bytes, std::size_t size,
                         char* out) {
  if (size >= kSmallChunk) return deflater.Deflate(bytes, size, out, size - 1);
  uLongf stored = uLongf(size - 1);
  const int status =
      compress2(reinterpret_cast<Bytef*>(out), &stored, bytes, uLong(size), kSmallLevel);
  return status == Z_OK ? stored : 0;
}

// Appends the chunk of rows that begins with row `y`.
void AppendExrChunk(std::int32_t y, std::string_view data, std::string& chunks) {
  static_assert(std::endian::native == std::endian::little);
  const auto size = std::int32_t(data.size());
  char start[kChunkStart];
  std::memcpy(start, &y, 4);
  std::memcpy(start + 4, &size, 4);
  chunks.append(start, sizeof start).append(data);
}

}  // namespace

std::uint16_t HalfBits(float value) {
  constexpr float kLargestHalf = 65504;
  return half(std::isfinite(value) ? std::clamp(value, -kLargestHalf, kLargestHalf) : value).bits();
}

bool CanEncodeStrip(ExrCompression compression) {
  return compression == ExrCompression::kNone || compression == ExrCompression::kZips ||
         compression == ExrCompression::kZip;
}

std::string EncodeStrip(ExrCompression compression, const std::vector<WrittenChannel>& channels,
                        int width, int first, int last, int top) {
  assert(CanEncodeStrip(compression));
  std::size_t row_pairs = 0;
  for (const WrittenChannel& channel : channels) {
    row_pairs += std::size_t(width) * (channel.half ? 1 : 2);
  }
  const int rows = int(RowsPerChunk(compression));
  const std::size_t most_pairs = row_pairs * std::size_t(std::min(rows, last - first));
  // The odd bytes follow the even ones at once.
  std::vector<std::uint8_t> split(2 * most_pairs), differences(2 * most_pairs);
  std::string data(2 * most_pairs, '\0'), chunks;
  Deflater deflater(kStripLevel);
  for (int y = first; y < last; y += rows) {
    const int end = std::min(y + rows, last);
    const std::size_t pairs = row_pairs * std::size_t(end - y), size = 2 * pairs;
    std::size_t at = 0;
    for (int row = y; row < end; ++row) {
      const std::size_t before = std::size_t(row) * std::size_t(width);
      for (const WrittenChannel& channel : channels) {
        SplitRow(channel.values + before * channel.stride, channel.stride, channel.half,
                 std::size_t(width), &split[at], &split[pairs + at]);
        at += std::size_t(width) * (channel.half ? 1 : 2);
      }
    }
    std::size_t stored = 0;
    if (compression != ExrCompression::kNone) {
      // Bytes are stored as differences from those before them ("Predictor" in the library's
      // ImfZip.cpp).
      differences[0] = split[0];
      for (std::size_t i = 1; i < size; ++i) {
        differences[i] = std::uint8_t(split[i] - split[i - 1] + 128);
      }
      stored = DeflateChunk(deflater, differences.data(), size, data.data());
    }
    if (stored == 0) {  // compression would not have made it smaller
      Interleave(split.data(), split.data() + pairs, pairs, data.data());
      stored = size;
    }
    AppendExrChunk(top + y, std::string_view(data).substr(0, stored), chunks);
  }
  return chunks;
}

}  // namespace skywave
