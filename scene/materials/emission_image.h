// The texture of an emission as lights are made of it: how bright it is where.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "image/image.h"
#include "scene/scene.h"

namespace skywave {

// Refers to `image` and `texture`.
class EmissionImage {
 public:
  EmissionImage(const Image& image, const Texture& texture);

  const glm::vec3& brightest() const { return brightest_; }  // of each channel, texels
  // The mean over a triangle whose corners have the coordinates `uv`, estimated at points that
  // cover it evenly. Black only if no lookup in the triangle can see light: where the points have
  // missed what is bright, it is a small share of the brightest texel.
  glm::vec3 Mean(const std::array<glm::vec2, 3>& uv) const;

 private:
  glm::vec3 Nearest(const glm::vec2& at) const;
  bool IsLit(const std::array<glm::vec2, 3>& at) const;

  const Image& image_;
  const Texture& texture_;
  glm::vec3 brightest_{0.0f};
  // Texels that are not black in the rows above and the columns left of an edge: (width + 1) x
  // (height + 1).
  std::vector<std::uint32_t> lit_;
};

}  // namespace skywave
