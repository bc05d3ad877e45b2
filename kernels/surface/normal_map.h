// Normal maps: shading normals bent by textures.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/texture.h"

namespace skywave {

// One a material.
struct NormalMapRecord {
  std::uint32_t texture;  // row in the texture table + 1; 0: none. Texels of PackNormalTexel
  float scale;            // of what the map says in the directions of the surface
  // 1: the map holds slopes a texel, of heights that are lengths in the world; else 0.
  std::uint32_t per_texel;
  std::uint32_t unused;
};
inline constexpr int kLogNormalMapWords = 2;
static_assert(sizeof(NormalMapRecord) == sizeof(std::uint32_t) << kLogNormalMapWords);

// The axis of a map at the corners of a triangle.
struct TriangleTangents {
  std::uint32_t tangent[3];  // where the map's x points in the world (EncodeNormal)
  float side;                // its y points along side * (outer normal x tangent); 0: no map here
};
inline constexpr int kLogTangentWords = 2;
static_assert(sizeof(TriangleTangents) == sizeof(std::uint32_t) << kLogTangentWords);

// All null in scenes without normal maps.
struct NormalMapView {
  const NormalMapRecord* records = nullptr;    // by material
  const TriangleTangents* tangents = nullptr;  // by triangle
  bool empty() const { return records == nullptr; }
};

// Bends ns of rows [0, n) whose material has a normal map. A normal that would look away from the
// eye is turned towards it until it just does not. `pixel_angle` as in TextureColors. Padding rows
// may be written.
void BendNormals(const TextureView& textures, const NormalMapView& maps, float pixel_angle,
                 std::uint32_t n, const SurfaceColumns& surfaces);

// The texel of a normal, 11 bits of x and y and 10 of z; any length but 0. x points right in the
// image, y up and z off the surface. (0, 0, 1) comes back exactly.
std::uint32_t PackNormalTexel(const float* xyz);

}  // namespace skywave
