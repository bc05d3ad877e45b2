// Textures that are computed from others: evaluated once, texel by texel, into an image.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

#include "scene/scene.h"

namespace skywave {

// `factor`, times the texture's image where there is one.
struct TextureOperand {
  glm::vec3 factor{1.0f};
  const Texture* texture = nullptr;
};

// Longest side of an image that is made, and texels of all that a scene may make.
inline constexpr int kMaxBakedSide = 2048;
inline constexpr std::size_t kMaxBakedTexels = std::size_t{1} << 25;

// A check of a checkerboard has so many texels a side; its edges are as soft as one of them.
inline constexpr int kCheckTexels = 64;
// 0 in the checks of even, 1 in those of odd floor(s) + floor(t); s and t go from 0 to 2, t
// upwards.
Image CheckerSelector();

// The texture of `combine`(values of the operands) for every (u, v); adds its image to the scene.
//
// Operands that lie alike (same transform and wrap) are combined in their own square, at the size
// of the largest: exact where sizes are equal. Others are combined over the unit square of (u, v)
// if each repeats a whole number of times in it, at the size of the finest of them, kMaxBakedSide
// at most; nothing is returned if one does not. At least one operand has a texture.
using CombineTexels = std::function<glm::vec3(std::span<const glm::vec3>)>;
std::optional<Texture> BakeTexture(std::span<const TextureOperand> operands,
                                   const CombineTexels& combine, Scene& scene);

}  // namespace skywave
