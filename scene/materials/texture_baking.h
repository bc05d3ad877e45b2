// Textures that are computed from others are evaluated once, texel by texel, into an image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "scene/scene.h"

namespace skywave {

// An operand is `factor`, times the texture's image where there is one.
struct TextureOperand {
  glm::vec3 factor{1.0f};
  const Texture* texture = nullptr;
};

inline constexpr int kMaxBakedSide = 2048;  // longest side of a baked image [texels]
// The number of texels of all baked images of a scene is at most this.
inline constexpr std::size_t kMaxBakedTexels = std::size_t{1} << 25;

// A check of a checkerboard has this many texels per side; its edges are as soft as one of them.
inline constexpr int kCheckTexels = 64;
// Returns an image that is 0 in the checks of even and 1 in those of odd floor(s) + floor(t); s and
// t go from 0 to 2, t upwards.
Image CheckerSelector();

// Images of a scene of which the nearest texel counts.
inline constexpr int kMaxUnfilteredSide = kMaxBakedSide / 4;  // [texels]
struct UnfilteredImages {
  std::map<std::uint32_t, std::uint32_t> known = {};  // by the image with texels as they are
  std::string name;                                   // of the filter in the file, for warnings
  // Returns the index of an image of the scene in which each texel is a square of them, so that
  // only its rim is interpolated. `baked` counts the texels of the scene's baked images. An image
  // of more than kMaxUnfilteredSide texels per side, or one too many, is interpolated as it is:
  // `warn` gets the text.
  std::uint32_t Of(std::uint32_t image, std::size_t& baked, Scene& scene,
                   const std::function<void(const std::string&)>& warn);
};

// Interpolates bilinearly between texel centres; `at` is in units of the image, wrapped as the
// texture has it.
glm::vec3 LookUpImage(const CompactImage& image, const Texture& texture, const glm::dvec2& at);

// Returns the texture of `combine`(values of the operands) for every (u, v), and adds its image to
// the scene. At least one operand has a texture.
//
// Operands that lie alike (same transform and wrap) are combined in their own square, at the size
// of the largest, which is exact where sizes are equal. Others are combined over the unit square of
// (u, v) if each repeats a whole number of times in it, at the size of the finest of them, but at
// most kMaxBakedSide; if one does not, nothing is returned.
using CombineTexels = std::function<glm::vec3(std::span<const glm::vec3>)>;
std::optional<Texture> BakeTexture(std::span<const TextureOperand> operands,
                                   const CombineTexels& combine, Scene& scene);

}  // namespace skywave
