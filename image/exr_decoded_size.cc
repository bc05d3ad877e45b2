#include "image/exr_decoded_size.h"

#define ZLIB_CONST
#include <zlib.h>

#include <cstddef>

namespace skywave {
namespace {

// A count n >= 0 repeats the next byte n + 1 times; n < 0 is followed by -n literal bytes.
std::int64_t RunLengthDecodedSize(std::string_view stored, std::int64_t most) {
  std::int64_t decoded = 0;
  for (std::size_t i = 0; i < stored.size();) {
    const int count = static_cast<signed char>(stored[i]);
    i += 1 + (count < 0 ? -count : 1);
    decoded += count < 0 ? -count : count + 1;
    if (i > stored.size() || decoded > most) return -1;
  }
  return decoded;
}

std::int64_t InflatedSize(std::string_view stored, std::int64_t most) {
  z_stream stream = {};
  if (inflateInit(&stream) != Z_OK) return -1;
  stream.next_in = reinterpret_cast<const Bytef*>(stored.data());
  stream.avail_in = uInt(stored.size());
  Bytef discarded[1 << 15];
  int status = Z_OK;
  std::int64_t decoded = 0;
  while (status == Z_OK && decoded <= most) {
    stream.next_out = discarded;
    stream.avail_out = sizeof discarded;
    status = inflate(&stream, Z_NO_FLUSH);
    decoded += std::int64_t(sizeof discarded) - stream.avail_out;
  }
  inflateEnd(&stream);
  return status == Z_STREAM_END && decoded <= most ? decoded : -1;
}

}  // namespace

std::int64_t DecodedSize(ExrCompression compression, std::string_view stored, std::int64_t most) {
  switch (compression) {
    case ExrCompression::kRle:
      return RunLengthDecodedSize(stored, most);
    case ExrCompression::kZips:
    case ExrCompression::kZip:
      return InflatedSize(stored, most);
    default:
      return most;
  }
}

}  // namespace skywave
