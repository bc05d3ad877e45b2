// Arranges many small pictures on one sheet, each with a caption above it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace skywave {

// A picture and its position in the sheet's grid, counted from the top left corner.
struct SheetPicture {
  int row = 0, column = 0;
  std::string caption;             // digits and the letters of layer names; cut at the right border
  const Image* picture = nullptr;  // all have the same size
};

// 8-bit sRGB, rows from the top.
struct ContactSheet {
  int width = 0, height = 0;  // [pixels]
  std::vector<std::uint8_t> rgb;
};

// Positions without a picture stay grey, so that they do not look like dark ones.
ContactSheet MakeContactSheet(const std::vector<SheetPicture>& pictures, const ToneMapping& tone);

}  // namespace skywave
