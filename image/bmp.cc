// Reads BMP, with the headers of OS/2 and of all versions of Windows: palettes of 1 to 8 bits, run
// lengths of 4 and 8, and colours of 16, 24 and 32 bits, with masks or without.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <string>
#include <vector>

#include "image/byte_cursor.h"
#include "image/formats.h"

namespace skywave {
namespace {

enum class BmpCompression : std::uint32_t { kNone, kRle8, kRle4, kMasks, kAlphaMasks = 6 };

struct BmpHeader {
  std::size_t pixels = 0;  // offset of the pixels [bytes]
  std::int32_t width = 0, height = 0;
  bool from_top = false;
  int bits = 0;  // per pixel
  BmpCompression compression = BmpCompression::kNone;
  std::array<std::uint32_t, 4> masks = {};  // red, green, blue, alpha; 0: the colours have none
  // The fourth byte of old files is alpha or unused, and then 0.
  bool opaque_if_all_zero = false;
  std::vector<std::array<std::uint8_t, 3>> palette;  // red, green, blue
};

BmpHeader ReadHeader(const std::string& path, std::string_view bytes, const ReadLimits& limits) {
  constexpr std::size_t kFile = 14, kOldest = 12, kWindows3 = 40, kLastOfOs2 = 64;
  constexpr std::size_t kThreeMasks = 52, kFourMasks = 56, kLongest = 124;
  ByteCursor cursor(path, bytes);
  constexpr const char* kWhat = "the BMP header";
  cursor.Take(kFile - 4, kWhat);
  BmpHeader header;
  header.pixels = cursor.U32(kWhat);
  const std::size_t size = cursor.U32(kWhat);
  const bool oldest = size == kOldest;
  const bool os2 = oldest || (size >= 16 && size < kWindows3) || size == kLastOfOs2;
  if (!os2 && (size < kWindows3 || size > kLongest)) {
    cursor.Fail("a BMP header of " + std::to_string(size) + " bytes is not known");
  }
  std::int64_t width = 0, height = 0;
  if (oldest) {
    width = cursor.U16(kWhat), height = cursor.U16(kWhat);
  } else {
    width = cursor.I32(kWhat), height = cursor.I32(kWhat);
  }
  CheckSize(InputPosition::Byte(path, kFile + 4), width, std::abs(height), limits);
  header.width = std::int32_t(width), header.height = std::int32_t(std::abs(height));
  header.from_top = height < 0;
  cursor.U16(kWhat);  // one plane
  header.bits = cursor.U16(kWhat);
  // A header may end before its numbers do, which are 0 then.
  ByteCursor rest(path, bytes.substr(0, std::min(bytes.size(), kFile + size)), cursor.offset());
  const auto next = [&] { return rest.left() >= 4 ? rest.U32(kWhat) : 0; };
  const std::uint32_t compression = next();
  for (int i = 0; i < 3; ++i) next();  // size of the pixels, and pixels per metre
  const std::uint32_t used = next();
  next();  // important colours
  header.compression = BmpCompression(compression);
  const bool has_masks = header.compression == BmpCompression::kMasks ||
                         header.compression == BmpCompression::kAlphaMasks;
  if (compression > std::uint32_t(BmpCompression::kMasks) && !has_masks) {
    cursor.Fail("BMP compression " + std::to_string(compression) + " is not supported");
  }
  if (os2 && !oldest && has_masks) cursor.Fail("BMP of OS/2 with Huffman codes is not supported");

  std::size_t end = kFile + size;
  if (has_masks) {
    const bool inside = size >= kThreeMasks;
    const bool alpha =
        inside ? size >= kFourMasks : header.compression == BmpCompression::kAlphaMasks;
    const std::size_t before = kFile + std::min(size, kWindows3);
    if (before > bytes.size()) cursor.Fail("the file ends within the BMP header");
    ByteCursor masks(path, bytes, before);
    for (int c = 0; c < (alpha ? 4 : 3); ++c) header.masks[std::size_t(c)] = masks.U32(kWhat);
    if (!inside) end = masks.offset();
  } else if (header.bits == 16) {
    header.masks = {0x7C00, 0x03E0, 0x001F, 0};
  } else if (header.bits == 24) {
    header.masks = {0xFF0000, 0xFF00, 0xFF, 0};
  } else if (header.bits == 32) {
    header.masks = {0xFF0000, 0xFF00, 0xFF, 0xFF000000};
    header.opaque_if_all_zero = true;
  }
  if (header.bits <= 8) {
    // Some files count more or fewer colours than their pixels can name.
    const std::size_t most = std::size_t{1} << header.bits, entry = oldest ? 3 : 4;
    const std::size_t room = header.pixels > end ? (header.pixels - end) / entry : 0;
    const std::size_t count = std::min({used > 0 ? std::size_t(used) : most, most, room});
    ByteCursor colors(path, bytes, std::min(end, bytes.size()));
    if (count == 0) colors.Fail("a BMP of 8 bits or less has no palette");
    for (std::size_t i = 0; i < count; ++i) {
      const std::string_view color = colors.Take(entry, "the palette of a BMP");
      header.palette.push_back(
          {std::uint8_t(color[2]), std::uint8_t(color[1]), std::uint8_t(color[0])});
    }
  }
  return header;
}

// Returns the bits of `word` under `mask` as a number of 8 bits.
std::uint8_t Masked(std::uint32_t word, std::uint32_t mask) {
  if (mask == 0) return 0;
  const int shift = std::countr_zero(mask);
  const std::uint64_t most = mask >> shift, value = (word & mask) >> shift;
  return std::uint8_t((value * 255 + most / 2) / most);
}

// Calls set(x, row, index) for the pixels of a picture of run lengths; rows are those of the file.
template <class Set>
void DecodeRuns(ByteCursor& cursor, const BmpHeader& header, const Set& set) {
  const bool nibbles = header.compression == BmpCompression::kRle4;
  constexpr const char* kWhat = "the pixels of a BMP";
  std::int64_t x = 0, row = 0;
  const auto put = [&](int index) {
    if (x < header.width && row < header.height) set(int(x), int(row), index);
    ++x;
  };
  while (row < header.height) {
    const int count = cursor.U8(kWhat), value = cursor.U8(kWhat);
    if (count > 0) {
      for (int i = 0; i < count; ++i) put(!nibbles ? value : i % 2 == 0 ? value >> 4 : value & 15);
    } else if (value == 0) {
      x = 0, ++row;
    } else if (value == 1) {
      return;
    } else if (value == 2) {
      x += cursor.U8(kWhat), row += cursor.U8(kWhat);
    } else {
      const std::size_t size = nibbles ? std::size_t(value + 1) / 2 : std::size_t(value);
      const std::string_view plain = cursor.Take(size + size % 2, kWhat);
      for (int i = 0; i < value; ++i) {
        const auto byte = std::uint8_t(plain[std::size_t(nibbles ? i / 2 : i)]);
        put(!nibbles ? byte : i % 2 == 0 ? byte >> 4 : byte & 15);
      }
    }
  }
}

// Writes the pixels of a row that has no palette: red, green, blue and alpha.
void DecodeColors(const std::uint8_t* line, const BmpHeader& header, std::uint8_t* rgba) {
  const int bytes = header.bits / 8;
  for (int x = 0; x < header.width; ++x, line += bytes, rgba += 4) {
    std::uint32_t word = 0;
    for (int byte = bytes; byte-- > 0;) word = word << 8 | line[byte];
    for (std::size_t c = 0; c < 4; ++c) rgba[c] = Masked(word, header.masks[c]);
    if (header.masks[3] == 0) rgba[3] = 255;
  }
}

}  // namespace

CompactImage DecodeBmp(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits) {
  const BmpHeader header = ReadHeader(path, bytes, limits);
  ByteCursor cursor(path, bytes, std::min(header.pixels, bytes.size()));
  const int bits = header.bits;
  const bool runs =
      header.compression == BmpCompression::kRle8 || header.compression == BmpCompression::kRle4;
  const bool known = runs ? bits == (header.compression == BmpCompression::kRle8 ? 8 : 4)
                          : bits == 1 || bits == 2 || bits == 4 || bits == 8 || bits == 16 ||
                                bits == 24 || bits == 32;
  if (!known) {
    cursor.Fail("a BMP of " + std::to_string(bits) + " bits" + (runs ? " by run lengths" : "") +
                " is not supported");
  }
  const std::size_t row_bytes = (std::size_t(header.width) * std::size_t(bits) + 31) / 32 * 4;
  // Memory follows the contents of the file, not the claims of its header. Two bytes of run lengths
  // hold up to 255 pixels, and jumps are rare.
  constexpr std::size_t kPixelsPerByte = 512, kFewPixels = 1 << 22;
  const std::size_t pixels = std::size_t(header.width) * std::size_t(header.height);
  if (runs ? pixels > kFewPixels && pixels / kPixelsPerByte > cursor.left()
           : cursor.left() / row_bytes < std::size_t(header.height)) {
    cursor.Fail("the file ends within the pixels of a BMP");
  }
  std::vector<std::uint8_t> rgba(4 * pixels);
  const auto pixel = [&](int x, int row) {
    const int y = header.from_top ? row : header.height - 1 - row;
    return &rgba[4 * (std::size_t(y) * std::size_t(header.width) + std::size_t(x))];
  };
  const auto set_index = [&](int x, int row, int index) {
    // A colour that the palette does not have is black.
    if (std::size_t(index) < header.palette.size()) {
      std::copy_n(header.palette[std::size_t(index)].data(), 3, pixel(x, row));
    }
    pixel(x, row)[3] = 255;
  };
  if (runs) {
    for (int row = 0; row < header.height; ++row) {
      for (int x = 0; x < header.width; ++x) set_index(x, row, 0);
    }
    DecodeRuns(cursor, header, set_index);
  }
  for (int row = 0; !runs && row < header.height; ++row) {
    const auto* const line =
        reinterpret_cast<const std::uint8_t*>(cursor.Take(row_bytes, "the pixels").data());
    if (bits > 8) DecodeColors(line, header, pixel(0, row));
    for (int x = 0; bits <= 8 && x < header.width; ++x) {
      const std::size_t bit = std::size_t(x) * std::size_t(bits);
      const int shift = 8 - bits - int(bit % 8);
      set_index(x, row, line[bit / 8] >> shift & ((1 << bits) - 1));
    }
  }
  bool any_alpha = !header.opaque_if_all_zero;
  for (std::size_t i = 3; i < rgba.size(); i += 4) any_alpha = any_alpha || rgba[i] != 0;
  for (std::size_t i = 3; !any_alpha && i < rgba.size(); i += 4) rgba[i] = 255;
  return FromRgba(header.width, header.height, rgba.data(), encoding);
}

}  // namespace skywave
