// The texture of an emission as the builder of lights sees it: how bright each triangle is.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "image/compact_image.h"
#include "scene/scene.h"

namespace skywave {

// An EmissionImage refers to `image` and `texture`, which must outlive it.
class EmissionImage {
 public:
  EmissionImage(const CompactImage& image, const Texture& texture);

  const glm::vec3& brightest() const { return brightest_; }  // largest texel, per channel
  // Returns the mean over a triangle whose corners have the coordinates `uv`, estimated at points
  // that cover it evenly. It is black only if no lookup in the triangle can see light: where the
  // points have missed the bright texels, it is a small share of the brightest one.
  glm::vec3 Mean(const std::array<glm::vec2, 3>& uv) const;

 private:
  glm::vec3 Nearest(const glm::vec2& at) const;
  bool IsLit(const std::array<glm::vec2, 3>& at) const;

  const CompactImage& image_;
  const Texture& texture_;
  glm::vec3 brightest_{0.0f};
  // The numbers of texels that are not black in the rows above and the columns left of an edge:
  // (width + 1) x (height + 1).
  std::vector<std::uint32_t> lit_;
};

}  // namespace skywave
