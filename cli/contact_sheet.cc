#include "cli/contact_sheet.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace skywave {
namespace {

constexpr int kGap = 2;                      // between pictures [pixels]
constexpr int kGlyphRows = 7, kAdvance = 6;  // size of a letter, which is five columns wide
constexpr int kCaption = kGlyphRows + 4;     // height of a caption's strip
constexpr std::uint8_t kPaper = 72, kInk = 235;

struct Glyph {
  char letter;
  std::array<std::uint8_t, kGlyphRows> rows;  // five bits each, with the left column in the highest
};
constexpr Glyph kGlyphs[] = {
    {'0', {0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110}},
    {'1', {0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'2', {0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111}},
    {'3', {0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110}},
    {'4', {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010}},
    {'5', {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110}},
    {'6', {0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110}},
    {'7', {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000}},
    {'8', {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110}},
    {'9', {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100}},
    {'d', {0b00001, 0b00001, 0b01101, 0b10011, 0b10001, 0b10001, 0b01111}},
    {'e', {0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110}},
    {'g', {0b00000, 0b01111, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110}},
    {'h', {0b10000, 0b10000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001}},
    {'i', {0b00100, 0b00000, 0b01100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'n', {0b00000, 0b00000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001}},
    {'s', {0b00000, 0b00000, 0b01111, 0b10000, 0b01110, 0b00001, 0b11110}},
    {'t', {0b01000, 0b01000, 0b11110, 0b01000, 0b01000, 0b01001, 0b00110}},
    {'u', {0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b10011, 0b01101}},
    {'w', {0b00000, 0b00000, 0b10001, 0b10001, 0b10101, 0b10101, 0b01010}},
    {'_', {0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b11111}},
};

std::uint8_t* PixelOf(ContactSheet& sheet, int x, int y) {
  return sheet.rgb.data() + 3 * (std::size_t(y) * std::size_t(sheet.width) + std::size_t(x));
}

// Writes from (x, y) on, no farther than `end`.
void Write(ContactSheet& sheet, const std::string& text, int x, int y, int end) {
  for (const char letter : text) {
    const Glyph* const glyph =
        std::find_if(std::begin(kGlyphs), std::end(kGlyphs),
                     [letter](const Glyph& candidate) { return candidate.letter == letter; });
    if (glyph != std::end(kGlyphs)) {
      for (int row = 0; row < kGlyphRows; ++row) {
        for (int column = 0; column < 5 && x + column < end; ++column) {
          const bool ink = (glyph->rows[std::size_t(row)] >> (4 - column) & 1) != 0;
          if (ink) std::fill_n(PixelOf(sheet, x + column, y + row), 3, kInk);
        }
      }
    }
    x += kAdvance;
  }
}

}  // namespace

ContactSheet MakeContactSheet(const std::vector<SheetPicture>& pictures, const ToneMapping& tone) {
  int rows = 0, columns = 0;
  for (const SheetPicture& at : pictures) {
    rows = std::max(rows, at.row + 1), columns = std::max(columns, at.column + 1);
  }
  const int width = pictures[0].picture->width, height = pictures[0].picture->height;
  const int step_x = width + kGap, step_y = kCaption + height + kGap;
  ContactSheet sheet = {
      .width = columns * step_x - kGap, .height = rows * step_y - kGap, .rgb = {}};
  sheet.rgb.assign(3 * std::size_t(sheet.width) * std::size_t(sheet.height), kPaper);
  for (const SheetPicture& at : pictures) {
    const int left = at.column * step_x, top = at.row * step_y;
    Write(sheet, at.caption, left + 2, top + 2, left + width);
    const std::vector<std::uint8_t> mapped = ToneMap(*at.picture, tone);
    for (int y = 0; y < height; ++y) {
      std::copy_n(mapped.data() + 3 * std::size_t(y) * std::size_t(width), 3 * width,
                  PixelOf(sheet, left, top + kCaption + y));
    }
  }
  return sheet;
}

}  // namespace skywave
