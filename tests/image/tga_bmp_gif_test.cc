// Reads TGA, BMP and GIF textures that are written here after the specifications (Truevision TGA
// 2.0, the structures BITMAPFILEHEADER and BITMAPINFOHEADER of Windows, GIF89a), whole and damaged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// Red, green, blue and alpha, rows from the top.
struct Pixels {
  int width, height;
  std::vector<std::uint8_t> rgba;
  const std::uint8_t* At(int x, int y) const { return &rgba[std::size_t(4 * (y * width + x))]; }
};

// No two pixels are equal, nor two channels of one; rows are long enough for stb_image's buffers of
// 128 bytes to end within them.
Pixels Picture(int width, int height) {
  Pixels pixels{width, height, {}};
  for (int i = 0; i < width * height; ++i) {
    for (const int value : {i, 255 - i, 7 * i + 3, 40 + i})
      pixels.rgba.push_back(std::uint8_t(value));
  }
  return pixels;
}

std::string U16(int value) { return {char(value), char(value >> 8)}; }
std::string U32(int value) { return U16(value) + U16(value >> 16); }

enum class TgaType { kColor = 2, kGrey = 3, kColorRuns = 10 };
std::string TgaHeader(TgaType type, int width, int height, int bits, bool from_top) {
  std::string tga = {'\0', '\0', char(type)};
  tga += std::string(9, '\0') + U16(width) + U16(height);
  return tga + char(bits) + char(from_top ? 0x20 : 0);
}

std::string TgaPixel(const std::uint8_t* rgba, int bits) {
  if (bits == 8) return {char(rgba[0])};
  std::string bytes = {char(rgba[2]), char(rgba[1]), char(rgba[0])};
  return bits == 32 ? bytes + char(rgba[3]) : bytes;
}

std::string Tga(const Pixels& from, TgaType type, int bits, bool from_top) {
  std::string tga = TgaHeader(type, from.width, from.height, bits, from_top);
  for (int row = 0; row < from.height; ++row) {
    const int y = from_top ? row : from.height - 1 - row;
    for (int x = 0; x < from.width; ++x) tga += TgaPixel(from.At(x, y), bits);
  }
  return tga;
}

// Packets of equal pixels (a count - 1 with the highest bit) and of others, in turns; they may go
// on from row to row.
std::string TgaOfRuns(const Pixels& from, int bits) {
  std::string tga = TgaHeader(TgaType::kColorRuns, from.width, from.height, bits, true);
  const int count = from.width * from.height;
  for (int i = 0; i < count;) {
    const auto equal = [&](int k) {
      return std::equal(from.At(i, 0), from.At(i, 0) + 4, from.At(k, 0));
    };
    int end = i + 1;
    while (end < count && end - i < 128 && equal(end)) ++end;
    if (end - i > 1) {
      tga += char(0x80 | (end - i - 1));
      tga += TgaPixel(from.At(i, 0), bits);
    } else {
      end = std::min(i + 5, count);
      tga += char(end - i - 1);
      for (int k = i; k < end; ++k) tga += TgaPixel(from.At(k, 0), bits);
    }
    i = end;
  }
  return tga;
}

// A height below 0 means rows from the top. Rows are filled up to four bytes.
std::string Bmp(const Pixels& from, int bits, bool from_top) {
  std::string rows;
  for (int row = 0; row < from.height; ++row) {
    const int y = from_top ? row : from.height - 1 - row;
    for (int x = 0; x < from.width; ++x) rows += TgaPixel(from.At(x, y), bits);
    rows.resize((rows.size() + 3) / 4 * 4);
  }
  const int header = 14 + 40;
  return "BM" + U32(header + int(rows.size())) + U32(0) + U32(header) + U32(40) + U32(from.width) +
         U32(from_top ? -from.height : from.height) + U16(1) + U16(bits) + U32(0) +
         U32(int(rows.size())) + U32(2835) + U32(2835) + U32(0) + U32(0) + rows;
}

// Codes of growing length, lowest bits first, in blocks of up to 255 bytes.
std::string Lzw(const std::vector<std::uint8_t>& indices, int bits) {
  std::string bytes;
  unsigned pending = 0;
  int used = 0;
  const int clear = 1 << bits;
  int length = bits + 1, next = clear + 2;
  const auto put = [&](int code) {
    pending |= unsigned(code) << used;
    for (used += length; used >= 8; used -= 8, pending >>= 8) bytes += char(pending & 255);
  };
  std::map<std::string, int> codes;
  const auto code_of = [&](const std::string& text) {
    return text.size() == 1 ? int(std::uint8_t(text[0])) : codes.at(text);
  };
  put(clear);
  std::string text;
  for (const std::uint8_t index : indices) {
    const std::string longer = text + char(index);
    if (longer.size() == 1 || codes.count(longer)) {
      text = longer;
      continue;
    }
    put(code_of(text));
    codes[longer] = next;
    if (next++ == 1 << length) ++length;
    text = std::string(1, char(index));
  }
  put(code_of(text));
  put(clear + 1);
  if (used > 0) bytes += char(pending);
  std::string blocks(1, char(bits));
  for (std::size_t at = 0; at < bytes.size(); at += 255) {
    const std::string block = bytes.substr(at, 255);
    blocks += char(block.size()) + block;
  }
  return blocks + '\0';
}

std::string GifFrame(int width, int height, const std::vector<std::uint8_t>& indices,
                     int transparent) {
  return std::string("!\xf9\4\1", 4) + U16(0) + char(transparent) + '\0' + ',' + U16(0) + U16(0) +
         U16(width) + U16(height) + '\0' + Lzw(indices, 2);
}

// Two pictures of four colours, of which the last is transparent.
constexpr std::uint8_t kPalette[4][4] = {
    {250, 10, 30, 255}, {20, 220, 40, 255}, {1, 2, 200, 255}, {90, 91, 92, 0}};
std::vector<std::uint8_t> GifIndices(int width, int height) {
  std::vector<std::uint8_t> indices;
  for (int i = 0; i < width * height; ++i) indices.push_back(std::uint8_t((i / 3 + i / width) % 4));
  return indices;
}
std::string Gif(int width, int height) {
  std::string gif = "GIF89a" + U16(width) + U16(height) + "\x91" + std::string(2, '\0');
  for (const auto& color : kPalette) gif += {char(color[0]), char(color[1]), char(color[2])};
  const std::vector<std::uint8_t> first = GifIndices(width, height);
  const std::vector<std::uint8_t> second(first.size(), 1);
  return gif + GifFrame(width, height, first, 3) + GifFrame(width, height, second, 3) + ';';
}

void ExpectBytes(const Image& image, const Pixels& expected, Encoding encoding) {
  ASSERT_EQ(image.width, expected.width);
  ASSERT_EQ(image.height, expected.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const int channel = encoding == Encoding::kAlpha ? 3 : c;
        ASSERT_FLOAT_EQ(image.Pixel(x, y)[c], float(expected.At(x, y)[channel] / 255.0))
            << x << ", " << y << ", channel " << c;
      }
    }
  }
}

void ExpectColorsAndAlpha(const std::string& name, const std::string& bytes, Pixels expected,
                          bool has_alpha) {
  SCOPED_TRACE(name);
  if (!has_alpha) {
    for (std::size_t i = 3; i < expected.rgba.size(); i += 4) expected.rgba[i] = 255;
  }
  for (const Encoding encoding : {Encoding::kLinear, Encoding::kAlpha}) {
    ExpectBytes(DecodeTexture(name, bytes, encoding), expected, encoding);
  }
}

TEST(Tga, ColorsComeFromTheBottomAndFromTheTop) {
  const Pixels picture = Picture(47, 5);
  for (const bool from_top : {false, true}) {
    for (const int bits : {24, 32}) {
      ExpectColorsAndAlpha("a.tga", Tga(picture, TgaType::kColor, bits, from_top), picture,
                           bits == 32);
    }
  }
}

TEST(Tga, RunsGoOnFromRowToRow) {
  Pixels picture = Picture(47, 5);
  for (int i = 20; i < 200; ++i)
    std::copy_n(picture.At(19, 0), 4, &picture.rgba[std::size_t(4 * i)]);
  for (const int bits : {24, 32}) {
    ExpectColorsAndAlpha("a.tga", TgaOfRuns(picture, bits), picture, bits == 32);
  }
}

TEST(Tga, GreyIsInAllChannels) {
  Pixels picture = Picture(31, 6);
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    picture.rgba[i + 1] = picture.rgba[i + 2] = picture.rgba[i];
  }
  ExpectColorsAndAlpha("B.TGA", Tga(picture, TgaType::kGrey, 8, false), picture, false);
}

TEST(Tga, IsRecognisedByItsName) {
  const std::string tga = Tga(Picture(4, 3), TgaType::kColor, 24, true);
  EXPECT_THROW(DecodeTexture("a.png", tga, Encoding::kSrgb), InputError);
  const TemporaryFolder folder;
  EXPECT_EQ(ReadTexture(folder.Write("a.tga", tga), Encoding::kLinear).rgb,
            DecodeTexture("b.tga", tga, Encoding::kLinear).rgb);
  EXPECT_TRUE(IsOfScreen(folder.Path("a.tga")));
  EXPECT_EQ(DecodeTexture("a.tga", EncodePng(2, 1, {1, 2, 3, 4, 5, 6}), Encoding::kLinear).width,
            2);
}

// The pixels of a row may come from the right, which one bit of the header says.
// A palette may begin at another colour than 0, and stand beside pixels that do not use it.
TEST(Tga, PalettesMayBeginElsewhereOrBeUnused) {
  const std::string colors("\1\2\12\3\4\24\5\6\36", 9);  // red is the last of each
  const auto with_palette = [&](int type, int first, int bits, const std::string& pixels) {
    return std::string{'\2', '\1', char(type)} + U16(first) + U16(3) + char(24) + U32(0) + U16(3) +
           U16(1) + char(bits) + char(0x20) + "id" + colors + pixels;
  };
  const auto red_of = [](const std::string& file) {
    const Image image = DecodeTexture("a.tga", file, Encoding::kLinear);
    std::vector<int> red;
    for (int x = 0; x < image.width; ++x)
      red.push_back(int(std::lround(255 * image.Pixel(x, 0)[0])));
    return red;
  };
  const std::vector<int> expected = {30, 10, 20};
  EXPECT_EQ(red_of(with_palette(1, 0, 8, std::string("\2\0\1", 3))), expected);
  EXPECT_EQ(red_of(with_palette(1, 7, 8, std::string("\11\7\10", 3))), expected);
  EXPECT_EQ(red_of(with_palette(2, 7, 24, std::string("\0\0\36\0\0\12\0\0\24", 9))), expected);
  EXPECT_THROW(red_of(with_palette(1, 0xFFFE, 8, std::string("\2\0\1", 3))), InputError);
  EXPECT_THROW(red_of(with_palette(2, 0, 24, "").substr(0, 24)), InputError);
}

TEST(Tga, RowsFromTheRightAreTurned) {
  const Pixels picture = Picture(7, 3);
  std::string tga = Tga(picture, TgaType::kColor, 24, true);
  tga[17] = char(tga[17] | 0x10);
  const Image image = DecodeTexture("a.tga", tga, Encoding::kLinear);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 7; ++x) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(image.Pixel(6 - x, y)[c], float(picture.At(x, y)[c] / 255.0)) << x << ", " << y;
      }
    }
  }
}

// Returns a BMP with a header of Windows of `header` bytes, what follows it up to the pixels, and
// the rows.
std::string BmpWith(int header, int width, int height, int bits, int compression, int used,
                    const std::string& rest, const std::string& rows) {
  std::string dib = U32(header) + U32(width) + U32(height) + U16(1) + U16(bits) + U32(compression) +
                    U32(int(rows.size())) + U32(0) + U32(0) + U32(used) + U32(0);
  dib += rest;
  const int offset = 14 + int(dib.size());
  return "BM" + U32(offset + int(rows.size())) + U32(0) + U32(offset) + dib + rows;
}
std::vector<int> RedOf(const std::string& bmp) {
  std::vector<int> red;
  const Image image = DecodeTexture("a.bmp", bmp, Encoding::kLinear);
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    red.push_back(int(std::lround(255 * image.rgb[i])));
  }
  return red;
}
// Entries of blue, green, red and nothing; the reds are 10, 20, 30 and so on.
std::string RedPalette(int count, bool of_os2 = false) {
  std::string palette;
  for (int i = 0; i < count; ++i) {
    palette += std::string("\1\2", 2) + char(10 * (i + 1)) + (of_os2 ? "" : std::string(1, '\0'));
  }
  return palette;
}

TEST(Bmp, PalettesOfAllSizesAreRead) {
  const std::string fill(1, '\0');
  // Two rows of three pixels, the lower one first: colours 1, 0, 1 and 0, 1, 1.
  const std::string one_bit = std::string("\xa0\0\0\0\x60\0\0\0", 8);
  EXPECT_EQ(RedOf(BmpWith(40, 3, 2, 1, 0, 0, RedPalette(2), one_bit)),
            (std::vector<int>{10, 20, 20, 20, 10, 20}));
  const std::string two_bits = std::string("\xe4\0\0\0", 4);  // 3, 2, 1, 0
  EXPECT_EQ(RedOf(BmpWith(40, 4, 1, 2, 0, 0, RedPalette(4), two_bits)),
            (std::vector<int>{40, 30, 20, 10}));
  const std::string four_bits = std::string("\x21\x30\0\0", 4);
  EXPECT_EQ(RedOf(BmpWith(40, 3, 1, 4, 0, 4, RedPalette(4), four_bits)),
            (std::vector<int>{30, 20, 40}));
  // A palette of fewer colours than the pixels name: black.
  EXPECT_EQ(RedOf(BmpWith(40, 3, 1, 8, 0, 2, RedPalette(2), std::string("\1\0\7\0", 4))),
            (std::vector<int>{20, 10, 0}));
  // No colour at all is no picture: everything would be black.
  EXPECT_THROW(RedOf(BmpWith(40, 3, 1, 8, 0, 0, "", std::string("\1\0\7\0", 4))), InputError);
  // The header of OS/2 has short sizes and entries of three bytes.
  const std::string os2 = U32(12) + U16(3) + U16(1) + U16(1) + U16(4) + RedPalette(16, true);
  EXPECT_EQ(RedOf("BM" + U32(0) + U32(0) + U32(14 + int(os2.size())) + os2 + four_bits),
            (std::vector<int>{30, 20, 40}));
}

TEST(Bmp, RunLengthsOfFourAndEightBitsAreRead) {
  // Three of colour 1, then 0 2 3 as they are, the end of the row; two of colour 3, a jump of one
  // pixel, one of colour 2, the end. Pixels that are jumped over have colour 0.
  const std::string eight("\3\1\0\3\0\2\3\0\0\0\2\3\0\2\1\0\1\2\0\1", 20);
  EXPECT_EQ(RedOf(BmpWith(40, 6, 2, 8, 1, 4, RedPalette(4), eight)),
            (std::vector<int>{40, 40, 10, 30, 10, 10, 20, 20, 20, 10, 30, 40}));
  const std::string four("\3\x12\0\3\x01\x20\0\0\0\1", 10);
  EXPECT_EQ(RedOf(BmpWith(40, 6, 1, 4, 2, 4, RedPalette(4), four)),
            (std::vector<int>{20, 30, 20, 10, 20, 30}));
}

TEST(Bmp, MasksSayWhereTheColoursAre) {
  // Five bits of each, without masks; and 5, 6, 5 with them behind the old header.
  const std::string pair = U16(0x7C00 | 0x03E0) + U16(16 << 10);
  EXPECT_EQ(RedOf(BmpWith(40, 2, 1, 16, 0, 0, "", pair)), (std::vector<int>{255, 132}));
  const std::string masks = U32(0xF800) + U32(0x07E0) + U32(0x001F);
  EXPECT_EQ(RedOf(BmpWith(40, 2, 1, 16, 3, 0, masks, U16(0xF800) + U16(1 << 11))),
            (std::vector<int>{255, 8}));
  // The fifth header of Windows has masks, alpha among them, and much else.
  const std::string fifth =
      U32(0xFF) + U32(0xFF00) + U32(0xFF0000) + U32(int(0xFF000000)) + std::string(124 - 56, '\0');
  const std::string bmp = BmpWith(124, 2, 1, 32, 3, 0, fifth, "\x11\x22\x33\x44\x55\x66\x77\x88");
  EXPECT_EQ(RedOf(bmp), (std::vector<int>{0x11, 0x55}));
  EXPECT_FLOAT_EQ(DecodeTexture("a", bmp, Encoding::kAlpha).rgb[0], 0x44 / 255.0f);
  // A palette beside colours of 24 bits is a suggestion for screens.
  EXPECT_EQ(RedOf(BmpWith(40, 1, 1, 24, 0, 2, RedPalette(2), std::string("\1\2\x77\0", 4))),
            (std::vector<int>{0x77}));
}

TEST(Bmp, RowsAreFilledAndComeFromTheBottomOrTheTop) {
  for (const int width : {40, 41, 42, 43}) {
    const Pixels picture = Picture(width, 5);
    ExpectColorsAndAlpha("a.bmp", Bmp(picture, 24, false), picture, false);
    ExpectColorsAndAlpha("a", Bmp(picture, 24, true), picture, false);
    ExpectColorsAndAlpha("a.tga", Bmp(picture, 32, false), picture, true);
  }
}

TEST(Gif, IsTheFirstPictureWithItsTransparency) {
  const int width = 37, height = 29;
  Pixels expected{width, height, {}};
  for (const std::uint8_t index : GifIndices(width, height)) {
    // stb_image leaves transparent pixels black.
    for (int c = 0; c < 4; ++c) expected.rgba.push_back(index == 3 ? 0 : kPalette[index][c]);
  }
  ExpectColorsAndAlpha("a.gif", Gif(width, height), expected, true);
}

TEST(TgaBmpGif, ColorsAreOfSrgb) {
  const Pixels dark{1, 1, {5, 128, 255, 255}};
  for (const std::string& file : {Tga(dark, TgaType::kColor, 24, true), Bmp(dark, 24, false)}) {
    const Image image = DecodeTexture("a.tga", file, Encoding::kSrgb);
    EXPECT_NEAR(image.rgb[0], 5 / 255.0 / 12.92, 1e-7);
    EXPECT_NEAR(image.rgb[1], 0.2158605, 1e-6);  // IEC 61966-2-1
    EXPECT_EQ(image.rgb[2], 1.0f);
  }
}

// The files of this picture end with its last pixel, so each byte is needed, down to the GIF's
// first picture.
std::vector<std::string> Files() {
  const Pixels picture = Picture(44, 5);
  std::string gif = Gif(37, 29);
  gif.resize(gif.find("!\xf9", gif.find(',')));  // the first picture alone
  return {Tga(picture, TgaType::kColor, 24, true),
          Tga(picture, TgaType::kColor, 32, false),
          Tga(picture, TgaType::kGrey, 8, true),
          TgaOfRuns(picture, 24),
          Bmp(picture, 24, false),
          gif};
}

TEST(TgaBmpGif, EveryPrefixIsRefused) {
  for (const std::string& file : Files()) {
    EXPECT_NO_THROW(DecodeTexture("a.tga", file, Encoding::kSrgb));
    for (std::size_t length = 0; length < file.size(); ++length) {
      const std::string_view cut = std::string_view(file).substr(0, length);
      EXPECT_THROW(DecodeTexture("a.tga", cut, Encoding::kSrgb), InputError)
          << length << " of " << file.size();
    }
  }
}

TEST(TgaBmpGif, EveryFlippedBitIsSurvived) {
  ReadLimits limits;
  limits.max_pixels = 1 << 16;
  int refused = 0;
  for (const std::string& file : Files()) {
    for (std::size_t bit = 0; bit < file.size() * 8; ++bit) {
      std::string damaged = file;
      damaged[bit / 8] = char(damaged[bit / 8] ^ (1 << bit % 8));
      try {
        const Image image = DecodeTexture("a.tga", damaged, Encoding::kSrgb, limits);
        EXPECT_EQ(image.rgb.size(), std::size_t(image.width) * std::size_t(image.height) * 3);
      } catch (const InputError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 300);
}

std::string Refusal(const std::string& bytes, const ReadLimits& limits = {}) {
  try {
    DecodeTexture("dir/a.tga", bytes, Encoding::kSrgb, limits);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Bmp, RunLengthsOfFewBytesAreNoLargePicture) {
  const std::string bmp = BmpWith(40, 16384, 16384, 8, 1, 2, RedPalette(2), std::string("\0\1", 2));
  EXPECT_NE(Refusal(bmp).find("ends within the pixels"), std::string::npos) << Refusal(bmp);
}

TEST(TgaBmpGif, LimitsHoldBeforeAnythingIsDecoded) {
  ReadLimits narrow;
  narrow.max_width = 36;
  for (const std::string& file : Files()) {
    const std::string refusal = Refusal(file, narrow);
    EXPECT_NE(refusal.find("over the limit"), std::string::npos) << refusal;
  }
  for (const std::string& header :
       {TgaHeader(TgaType::kColorRuns, 65535, 65535, 32, true), Bmp({70000, 0, {}}, 24, false),
        Bmp({2147483647, 0, {}}, 24, false), "GIF89a" + U16(65535) + U16(65535) + "\x91\1\2"}) {
    EXPECT_NE(Refusal(header), "");
    EXPECT_EQ(Refusal(header).find("the file ends"), std::string::npos) << Refusal(header);
  }
}

TEST(TgaBmpGif, ErrorsNameFileAndReason) {
  std::string bmp = Bmp(Picture(4, 4), 24, false);
  bmp[30] = 1;  // run-length coded
  EXPECT_NE(Refusal(bmp).find("dir/a.tga (byte 54): a BMP of 24 bits by run lengths"),
            std::string::npos)
      << Refusal(bmp);
  std::string tga = Tga(Picture(4, 4), TgaType::kColor, 24, true);
  tga.pop_back();
  EXPECT_NE(Refusal(tga).find("is no TGA to read: the file ends"), std::string::npos)
      << Refusal(tga);
  tga[2] = 99;
  EXPECT_NE(Refusal(tga).find("is no TGA to read: "), std::string::npos) << Refusal(tga);
  std::string gif = Gif(3, 3);
  gif[10] = 0;  // no palette
  EXPECT_NE(Refusal(gif).find("is no GIF to read: "), std::string::npos) << Refusal(gif);
}

}  // namespace
}  // namespace skywave
