// Many small pictures on one sheet, each under its caption.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace skywave {

// A place in the sheet's grid, counted from its top left corner.
struct SheetPicture {
  int row = 0, column = 0;
  std::string caption;  // digits and the letters that names of layers have; cut at the right border
  const Image* picture = nullptr;  // all of one size
};

// 8-bit sRGB, rows from the top.
struct ContactSheet {
  int width = 0, height = 0;  // [pixels]
  std::vector<std::uint8_t> rgb;
};

// Places without a picture stay grey, so that they are not taken for dark ones.
ContactSheet MakeContactSheet(const std::vector<SheetPicture>& pictures, const ToneMapping& tone);

}  // namespace skywave
