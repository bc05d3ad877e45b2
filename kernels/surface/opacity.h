// Alpha decides whether a ray hits a triangle whose material is not opaque everywhere.
//
// Embree calls this while it traverses, for one candidate hit after the other, so it is scalar. The
// answer is a function of the key of the ray and of the triangle: it depends neither on the order
// in which Embree comes upon triangles nor on how often it asks. Textures are read at level 0, by
// the arithmetic of kernels/surface/texture-inl.h: a filtered mask would have no edge, and many
// samples average it anyway.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/texture.h"

namespace skywave {

// There is one record per material.
struct OpacityRecord {
  float factor;  // multiplies the texture
  // A ray hits where factor times texture reaches this; if it is negative, that product is the
  // share of rays that hit.
  float cutoff;
  std::uint32_t texture;  // row in the texture table + 1; 0: none; its first channel is read
  std::uint32_t unused;
};
static_assert(sizeof(OpacityRecord) == 4 * sizeof(float));

struct OpacityView {
  const TriangleRecord* triangles;
  const OpacityRecord* records;  // by material
  TextureView textures;
  const float* of_corners = nullptr;  // three per triangle: factors; null: all are 1
};

// Returns the opacity of `triangle` at barycentric (u, v): factor times texture times what its
// corners have, not clamped.
float Opacity(const OpacityView& view, std::uint32_t triangle, float u, float v);

// Returns true if the ray with that key hits the triangle there.
bool StopsRay(const OpacityView& view, std::uint32_t key, std::uint32_t triangle, float u, float v);

// Writes the keys of rays [0, n): hashes of the path in row `rows[i]` of `paths` and of `event`, a
// number for what the path uses the rays for.
void DrawRayKeys(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                 std::uint32_t event, std::uint32_t* keys);

}  // namespace skywave
