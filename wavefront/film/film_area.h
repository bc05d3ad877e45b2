// These are parts of films, in pixels.
#pragma once

#include <algorithm>

#include "kernels/camera.h"

namespace skywave {

// A crop window is the part of a film that is rendered.
struct CropWindow {
  int x = 0, y = 0, width = 0, height = 0;
  friend bool operator==(const CropWindow&, const CropWindow&) = default;
};

// Returns what two parts have in common; without pixels if that is nothing.
constexpr CropWindow Intersection(const CropWindow& a, const CropWindow& b) {
  const int x = std::max(a.x, b.x), y = std::max(a.y, b.y);
  return {x, y, std::max(std::min(a.x + a.width, b.x + b.width) - x, 0),
          std::max(std::min(a.y + a.height, b.y + b.height) - y, 0)};
}

// Returns the blocks of beams that `part` touches, which have to be rendered for it.
constexpr CropWindow WholeBlocks(const CropWindow& part) {
  const auto down = [](int pixel, int side) { return pixel / side * side; };
  const auto up = [&](int pixel, int side) { return down(pixel + side - 1, side); };
  const int x = down(part.x, kBeamWidth), y = down(part.y, kBeamHeight);
  return {x, y, up(part.x + part.width, kBeamWidth) - x, up(part.y + part.height, kBeamHeight) - y};
}

// A film keeps this area, and the picture is cut out of it.
struct FilmArea {
  int width, height;
  CropWindow picture;
};

}  // namespace skywave
