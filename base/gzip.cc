#include "base/gzip.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <vector>

#include "base/error.h"

namespace skywave {
namespace {

struct Inflation {
  z_stream stream = {};
  Inflation() { inflateInit2(&stream, 16 + MAX_WBITS); }  // 16 selects gzip instead of zlib
  ~Inflation() { inflateEnd(&stream); }
};

}  // namespace

std::string Gunzip(std::string bytes, const std::string& path, std::size_t max_bytes) {
  if (!bytes.starts_with("\x1f\x8b")) return bytes;
  Inflation inflation;
  z_stream& stream = inflation.stream;
  std::vector<char> chunk(std::size_t{1} << 18);
  std::string plain;
  std::size_t next = 0;
  int status = Z_OK;
  do {
    const auto given = uInt(std::min<std::size_t>(bytes.size() - next, 1u << 30));
    stream.next_in = reinterpret_cast<Bytef*>(bytes.data() + next);
    stream.avail_in = given;
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = uInt(chunk.size());
    status = inflate(&stream, Z_NO_FLUSH);
    next += given - stream.avail_in;
    if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR) {
      throw InputError(InputPosition::Byte(path, next),
                       "is not a valid gzip file: unpack it by hand");
    }
    plain.append(chunk.data(), chunk.size() - stream.avail_out);
    if (plain.size() > max_bytes) {
      throw InputError(InputPosition::Byte(path, next),
                       fmt::format("unpacks to more than {} bytes", max_bytes));
    }
    if (status == Z_STREAM_END && next < bytes.size()) inflateReset(&stream);
  } while (next < bytes.size() || (status == Z_OK && stream.avail_out == 0));
  if (status != Z_STREAM_END) {
    throw InputError(InputPosition::Byte(path, bytes.size()), "is a gzip file that is cut short");
  }
  return plain;
}

}  // namespace skywave
