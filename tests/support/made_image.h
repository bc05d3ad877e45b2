// Images whose pixels a function gives.
#pragma once

#include <algorithm>
#include <glm/glm.hpp>

#include "image/image.h"

namespace skywave {

// Returns an image whose pixel in column x and row y is `color(x, y)`, a glm::vec3.
template <class Color>
Image MadeImage(int width, int height, const Color& color) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec3 value = color(x, y);
      std::copy_n(&value.x, 3, image.Pixel(x, y));
    }
  }
  return image;
}

}  // namespace skywave
