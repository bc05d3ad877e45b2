// Holes: whether a ray meets a triangle whose material is not opaque everywhere.
//
// Asked while Embree traverses, for one candidate hit after the other, so this is scalar. The
// answer is a function of the key of the ray and of the triangle: it depends neither on the order
// in which Embree comes upon triangles nor on how often it asks. Textures are read at level 0, by
// the arithmetic of kernels/surface/texture-inl.h: a mean over holes is no edge, and many samples
// blend.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/texture.h"

namespace skywave {

// One a material.
struct OpacityRecord {
  float factor;           // times the texture
  float cutoff;           // met where the product reaches it; negative: met by that share of rays
  std::uint32_t texture;  // row in the texture table + 1; 0: none. Its first channel counts
  std::uint32_t unused;
};
static_assert(sizeof(OpacityRecord) == 4 * sizeof(float));

struct OpacityView {
  const TriangleRecord* triangles;
  const OpacityRecord* records;  // by material
  TextureView textures;
};

// Opacity of `triangle` at barycentric (u, v): factor times texture, not clamped.
float Opacity(const OpacityView& view, std::uint32_t triangle, float u, float v);

// Whether the ray of that key meets the triangle there.
bool StopsRay(const OpacityView& view, std::uint32_t key, std::uint32_t triangle, float u, float v);

// Writes keys of rays [0, n): hashes of the path in row `rows[i]` of `paths` and of `event`, the
// number of what the path uses the rays for.
void DrawRayKeys(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                 std::uint32_t event, std::uint32_t* keys);

}  // namespace skywave
