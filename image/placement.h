// Which pixels of a larger picture a part of it shows, and how parts are cut to the same ones.
#pragma once

#include <cstdint>

#include "image/image.h"

namespace skywave {

// Pixels of a picture, counted from its top left corner.
struct PixelBox {
  std::int64_t x = 0, y = 0, width = 0, height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
  friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

// Returns the larger picture, of which `picture` is a part or all.
PixelBox WholeOf(const LayeredImage& picture);
// Returns the pixels of it that `picture` shows.
PixelBox PartOf(const LayeredImage& picture);
// Returns the pixels that both boxes have; empty if there are none.
PixelBox Common(const PixelBox& a, const PixelBox& b);

// Makes `picture` show the pixels `box` of the larger picture: what it does not have of them is 0.
void CutTo(const PixelBox& box, LayeredImage& picture);

}  // namespace skywave
