// Parses OpenEXR headers and chunk tables strictly, before the OpenEXR library sees a file.
//
// The library in use (Debian's 3.1.5) trusts headers more than it should. Here every size is first
// checked against the file and the limits, so that it only ever gets files whose header, chunk
// table and chunk sizes agree. See "OpenEXR File Layout" in the OpenEXR documentation.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.h"
#include "image/primaries.h"

namespace skywave {

// Files ask for no threads. OpenEXR's global number of them is zero by default and is left alone,
// because it belongs to the program that uses the library.
inline constexpr int kNoExrThreads = 0;

struct ExrChannel {
  std::string name;
  int bytes = 0;  // per pixel: 2 (half) or 4 (float, unsigned)
  bool sub_sampled = false;
  bool is_whole = false;  // unsigned numbers
};

// Inclusive bounds [pixels], y down.
struct ExrBox {
  std::int32_t x_min = 0, y_min = 0, x_max = -1, y_max = -1;
  std::int64_t width() const { return std::int64_t(x_max) - x_min + 1; }
  std::int64_t height() const { return std::int64_t(y_max) - y_min + 1; }
};

enum class ExrLevels : std::uint8_t { kOne, kMipmap, kRipmap };
struct ExrTiles {
  std::int64_t width = 0, height = 0;  // [pixels] size of a full tile
  ExrLevels levels = ExrLevels::kOne;
  bool round_up = false;
};

struct ExrHeader {
  bool tiled = false;
  bool deep = false;
  bool multi_part = false;
  int part = 0;                  // of a file of several parts
  std::int64_t chunk_count = 0;  // likewise; otherwise it follows from the windows
  bool has_manifest = false;     // of object numbers
  ExrCompression compression = ExrCompression::kNone;
  ExrBox data_window, display_window;
  ExrTiles tiles;
  std::vector<ExrChannel> channels;
  std::optional<RgbPrimaries> primaries;  // of R, G and B, if the file says so
  Metadata strings;                       // attributes of type string
  std::size_t end = 0;                    // [bytes] offset of the chunk table, after all headers

  std::int64_t pixel_bytes() const;  // sum over all channels
  // Returns whether OpenEXR 3.1.5 has known holes in decoding such files, or whether what it does
  // with them was not checked before.
  bool risky() const;
};

// Returns the headers of the parts of an EXR file, of which most have one. In a file of one part
// sizes are checked against `limits`. Throws InputError with the byte offset.
std::vector<ExrHeader> ParseExrHeaders(const std::string& path, std::string_view bytes,
                                       const ReadLimits& limits);

// Returns how many rows of a file of scan lines are compressed together.
std::int64_t RowsPerChunk(ExrCompression compression);

// Decodes a chunk: its first row or column as the chunk gives it, the stored bytes, and how many
// they decode to. Returns whether they do.
using ExrChunkTaker =
    std::function<bool(std::int64_t first, std::string_view stored, std::int64_t decoded_bytes)>;

// Throws InputError unless a flat file, or a flat part of one, contains all chunks, each at its
// proper position and with its proper size. Then each is given to `take`, if there is one, by
// several threads and in any order.
void CheckExrChunks(const std::string& path, std::string_view bytes, const ExrHeader& header,
                    const ExrChunkTaker& take = {});

}  // namespace skywave
