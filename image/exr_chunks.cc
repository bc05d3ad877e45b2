#include <tbb/parallel_for.h>

#include <algorithm>

#include "image/byte_cursor.h"
#include "image/exr_decoded_size.h"
#include "image/exr_header.h"

namespace skywave {
namespace {

// The library allocates a whole decoded chunk at once, so its size is limited.
constexpr std::int64_t kMaxChunkBytes = std::int64_t{1} << 28;
// No lossless compression shrinks more than this (deflate: 1032, PIZ: about 400).
constexpr std::int64_t kMaxShrinking = 2048;

std::int64_t DivideUp(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

// Returns `size` at all its levels of detail, halved down to 1.
std::vector<std::int64_t> LevelSizes(std::int64_t size, std::int64_t longest, bool round_up) {
  std::vector<std::int64_t> sizes;
  for (int level = 0;; ++level) {
    const std::int64_t step = std::int64_t{1} << level;
    const auto at_level = [&](std::int64_t s) {
      return std::max<std::int64_t>(1, round_up ? DivideUp(s, step) : s / step);
    };
    sizes.push_back(at_level(size));
    if (at_level(longest) == 1) return sizes;
  }
}

// Walks through the table after the header, with one call of CheckNext per chunk in table order.
// Then Decode decodes the chunks, once all are known to be where they belong.
class ChunkChecker {
 public:
  ChunkChecker(const std::string& path, std::string_view bytes, const ExrHeader& header,
               const ExrChunkTaker& take)
      : path_(path), bytes_(bytes), header_(header), take_(take), table_(path, bytes, header.end) {}

  // Throws unless the table has room for `count` chunks; called before walking through them.
  void CheckTable(std::int64_t count) {
    if (header_.multi_part && count != header_.chunk_count) {
      table_.Fail("a part of " + std::to_string(count) + " chunks says that it has " +
                  std::to_string(header_.chunk_count));
    }
    table_end_ = table_.offset() + std::size_t(count) * 8;
    if (table_.left() / 8 < std::size_t(count)) {
      table_.Fail("the file ends within the chunk table");
    }
  }
  // `place` holds the numbers at the start of the chunk, `decoded_bytes` the size of its pixels.
  void CheckNext(std::initializer_list<std::int64_t> place, std::int64_t decoded_bytes) {
    const std::uint64_t offset = table_.U64("the chunk table");
    if (offset == 0) table_.Fail("a chunk was never written: the EXR is incomplete");
    if (offset < table_end_ || offset > bytes_.size()) {
      table_.Fail("a chunk lies outside of the file, which may be cut short");
    }
    ByteCursor chunk(path_, bytes_, offset);
    if (header_.multi_part && chunk.I32("a chunk") != header_.part) {
      chunk.Fail("a chunk of another part");
    }
    for (const std::int64_t number : place) {
      if (chunk.I32("a chunk") != number) chunk.Fail("a chunk that belongs somewhere else");
    }
    const std::int64_t stored = chunk.I32("a chunk");
    const bool plain = header_.compression == ExrCompression::kNone;
    if (stored < 1 || stored > decoded_bytes || (plain && stored != decoded_bytes)) {
      chunk.Fail("a chunk of " + std::to_string(stored) + " bytes for " +
                 std::to_string(decoded_bytes) + " bytes of pixels");
    }
    const std::string_view pixels = chunk.Take(std::size_t(stored), "a chunk");
    chunks_.push_back({*place.begin(), pixels, decoded_bytes, chunk.offset()});
  }
  void Decode() const {
    std::vector<char> decodes(chunks_.size());
    tbb::parallel_for(std::size_t{0}, chunks_.size(), [&](std::size_t i) {
      const Chunk& chunk = chunks_[i];
      // Chunks that compression would not shrink are stored uncompressed.
      const auto are_good = [&] {
        return std::int64_t(chunk.stored.size()) == chunk.decoded_bytes ||
               DecodedSize(header_.compression, chunk.stored, chunk.decoded_bytes) ==
                   chunk.decoded_bytes;
      };
      decodes[i] = take_ ? take_(chunk.first, chunk.stored, chunk.decoded_bytes) : are_good();
    });
    const auto bad = std::find(decodes.begin(), decodes.end(), false);
    if (bad == decodes.end()) return;
    const Chunk& chunk = chunks_[std::size_t(bad - decodes.begin())];
    ByteCursor(path_, bytes_, chunk.end)
        .Fail("the chunk that ends here does not decode to " + std::to_string(chunk.decoded_bytes) +
              " bytes of pixels");
  }

 private:
  struct Chunk {
    std::int64_t first;
    std::string_view stored;
    std::int64_t decoded_bytes;
    std::size_t end;  // [bytes] offset in the file
  };
  const std::string& path_;
  std::string_view bytes_;
  const ExrHeader& header_;
  const ExrChunkTaker& take_;
  std::vector<Chunk> chunks_;
  ByteCursor table_;
  std::uint64_t table_end_ = 0;
};

void CheckScanLines(ChunkChecker& checker, const ExrHeader& header) {
  const std::int64_t rows = RowsPerChunk(header.compression);
  const std::int64_t width = header.data_window.width(), height = header.data_window.height();
  checker.CheckTable(DivideUp(height, rows));
  for (std::int64_t y = 0; y < height; y += rows) {
    checker.CheckNext({header.data_window.y_min + y},
                      std::min(rows, height - y) * width * header.pixel_bytes());
  }
}

void CheckTiles(ChunkChecker& checker, const ExrHeader& header) {
  const ExrTiles& tiles = header.tiles;
  const std::int64_t width = header.data_window.width(), height = header.data_window.height();
  // Both sides of a mipmap are halved until the longer one is 1; the sides of a ripmap are halved
  // independently.
  const bool ripmap = tiles.levels == ExrLevels::kRipmap;
  const std::int64_t longest = std::max(width, height);
  std::vector<std::int64_t> widths = LevelSizes(width, ripmap ? width : longest, tiles.round_up);
  std::vector<std::int64_t> heights = LevelSizes(height, ripmap ? height : longest, tiles.round_up);
  if (tiles.levels == ExrLevels::kOne) {
    widths.resize(1);
    heights.resize(1);
  }
  struct Level {
    std::size_t x, y;
  };
  std::vector<Level> levels;
  for (std::size_t y = 0; y < heights.size(); ++y) {
    if (!ripmap) {
      levels.push_back({y, y});
      continue;
    }
    for (std::size_t x = 0; x < widths.size(); ++x) levels.push_back({x, y});
  }
  std::int64_t count = 0;
  for (const Level level : levels) {
    count += DivideUp(widths[level.x], tiles.width) * DivideUp(heights[level.y], tiles.height);
  }
  checker.CheckTable(count);
  for (const Level level : levels) {
    const std::int64_t w = widths[level.x], h = heights[level.y];
    for (std::int64_t y = 0; y < DivideUp(h, tiles.height); ++y) {
      for (std::int64_t x = 0; x < DivideUp(w, tiles.width); ++x) {
        const std::int64_t pixels = std::min(tiles.width, w - x * tiles.width) *
                                    std::min(tiles.height, h - y * tiles.height);
        checker.CheckNext({x, y, std::int64_t(level.x), std::int64_t(level.y)},
                          pixels * header.pixel_bytes());
      }
    }
  }
}

}  // namespace

std::int64_t RowsPerChunk(ExrCompression compression) {
  switch (compression) {
    case ExrCompression::kNone:
    case ExrCompression::kRle:
    case ExrCompression::kZips:
      return 1;
    case ExrCompression::kZip:
    case ExrCompression::kPxr24:
      return 16;
    case ExrCompression::kPiz:
    case ExrCompression::kB44:
    case ExrCompression::kB44a:
    case ExrCompression::kDwaa:
      return 32;
    case ExrCompression::kDwab:
      return 256;
  }
  return 1;
}

void CheckExrChunks(const std::string& path, std::string_view bytes, const ExrHeader& header,
                    const ExrChunkTaker& take) {
  const ByteCursor table(path, bytes, header.end);
  const std::int64_t width = header.data_window.width(), height = header.data_window.height();
  const std::int64_t chunk_pixels = header.tiled ? header.tiles.width * header.tiles.height
                                                 : width * RowsPerChunk(header.compression);
  if (chunk_pixels > kMaxChunkBytes / header.pixel_bytes()) {
    table.Fail("the chunks or tiles of this EXR are too large");
  }
  const bool lossless = header.compression <= ExrCompression::kPiz;
  if (lossless &&
      width * height * header.pixel_bytes() / kMaxShrinking > std::int64_t(bytes.size())) {
    table.Fail("the file is too short for " + std::to_string(width) + " x " +
               std::to_string(height) + " pixels");
  }
  ChunkChecker checker(path, bytes, header, take);
  if (header.tiled) {
    CheckTiles(checker, header);
  } else {
    CheckScanLines(checker, header);
  }
  checker.Decode();
}

}  // namespace skywave
