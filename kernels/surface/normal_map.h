// Normal maps bend shading normals by textures.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/texture.h"

namespace skywave {

// There is one record per material.
struct NormalMapRecord {
  std::uint32_t texture;  // row in the texture table + 1; 0: none. Texels of PackNormalTexel
  float scale;            // factor of the map's x and y
  // 1 if the map holds slopes per texel, of heights that are lengths in the world; else 0.
  std::uint32_t per_texel;
  std::uint32_t of_base;  // 1: these are normals of what lies below a coat; with or without texture
};
inline constexpr int kLogNormalMapWords = 2;
static_assert(sizeof(NormalMapRecord) == sizeof(std::uint32_t) << kLogNormalMapWords);

// These are the axes of a map at the corners of a triangle.
struct TriangleTangents {
  std::uint32_t tangent[3];  // direction of the map's x in the space of the mesh (EncodeNormal)
  float side;                // its y points along side * (outer normal x tangent); 0: no map here
};
inline constexpr int kLogTangentWords = 2;
static_assert(sizeof(TriangleTangents) == sizeof(std::uint32_t) << kLogTangentWords);

// How slopes per texel lie on a triangle: its texels may be stretched and skewed. The slope along x
// is `along` times that of the map, that along y is `across` times that of the map and `shear`
// times the one along x; all by texels per length, the root of texels per area.
struct TriangleSlopes {
  float along = 1, across = 1, shear = 0;
  std::uint32_t unused = 0;
};
inline constexpr int kLogSlopeWords = 2;
static_assert(sizeof(TriangleSlopes) == sizeof(std::uint32_t) << kLogSlopeWords);

// The first two pointers are null in scenes without normal maps, the third in those without heights
// that are lengths.
struct NormalMapView {
  const NormalMapRecord* records = nullptr;    // by material
  const TriangleTangents* tangents = nullptr;  // by triangle
  const TriangleSlopes* slopes = nullptr;  // by triangle; they are {} where there are no heights
  bool empty() const { return records == nullptr; }
};

// Bends ns of rows [0, n) whose material has a normal map. A normal that would face away from the
// eye is turned until it just faces it. `pixel_angle` is that of TextureColors. Padding rows may be
// written.
void BendNormals(const TextureView& textures, const NormalMapView& maps, float pixel_angle,
                 std::uint32_t n, const SurfaceColumns& surfaces);

// Writes base_normal of rows [0, n): ns bent likewise by the maps of bases, but not turned to the
// eye, and kSameNormal where the material has no base with normals of its own. This comes before
// BendNormals, which bends ns by the map of the coat. Padding rows may be written.
void WriteBaseNormals(const TextureView& textures, const NormalMapView& bases, float pixel_angle,
                      std::uint32_t n, const SurfaceColumns& surfaces);

// Packs a normal of any length but 0 into a texel, 11 bits each for x and y and 10 for z. x points
// right in the image, y up and z off the surface. (0, 0, 1) is kept exactly.
std::uint32_t PackNormalTexel(const float* xyz);

}  // namespace skywave
