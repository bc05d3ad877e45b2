// Textures of the oracle: bilinear look-ups in double in the image itself, without a pyramid.
// Pictures therefore match the engine's if pixels are smaller than texels.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "scene/scene.h"

namespace skywave {

// Returns the index of a texel that may lie outside a line of `count` texels.
inline int WrapTexel(int i, int count, TextureWrap wrap) {
  if (wrap == TextureWrap::kClamp) return std::clamp(i, 0, count - 1);
  const int period = wrap == TextureWrap::kMirror ? 2 * count : count;
  const int inside = (i % period + period) % period;
  return inside < count ? inside : period - 1 - inside;
}

// Interpolates the texels around `place` [texels; the corner of the first one is 0].
template <class AnyImage>  // Image or CompactImage
glm::dvec3 Bilinear(const AnyImage& image, glm::dvec2 place, TextureWrap wrap_u,
                    TextureWrap wrap_v) {
  const double x = place.x - 0.5, y = place.y - 0.5;
  const int column = int(std::floor(x)), row = int(std::floor(y));
  glm::dvec3 sum(0);
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double weight = std::abs(1 - i - (x - column)) * std::abs(1 - j - (y - row));
      const auto rgb = image.Pixel(WrapTexel(column + i, image.width, wrap_u),
                                   WrapTexel(row + j, image.height, wrap_v));
      sum += weight * glm::dvec3(rgb[0], rgb[1], rgb[2]);
    }
  }
  return sum;
}

inline glm::dvec3 LookUpTexture(const Scene& scene, std::uint32_t index, const glm::dvec2& uv) {
  const Texture& texture = scene.textures[index];
  const CompactImage& image = scene.images[texture.image];
  const glm::dvec2 at = glm::dmat3x2(texture.transform) * glm::dvec3(uv, 1);
  return Bilinear(image, at * glm::dvec2(image.width, image.height), texture.wrap_u,
                  texture.wrap_v);
}

}  // namespace skywave
