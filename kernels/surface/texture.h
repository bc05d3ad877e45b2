// Image textures give surfaces their colours, and metallic-roughness materials their parameters.
//
// Lookups are bilinear in one level of the mip pyramid. The level is that whose texels are as large
// as a cone of `pixel_angle` over the length of the ray (Akenine-Moller et al. 2021, "Improved
// Shader and Texture Level of Detail Using Ray Cones", Section 3): the geometric mean of both axes
// of the ellipse, rounded down. The cone starts anew at every surface, so textures seen in mirrors
// or by scattered light are sharper than necessary, never more blurred.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/instances.h"

namespace skywave {

// All pointers but the last are null in scenes without textures.
struct TextureView {
  const TextureRecord* records = nullptr;
  const TextureLevel* levels = nullptr;
  const std::uint32_t* texels = nullptr;      // PackTexel, row by row from the top
  const TriangleUvs* uvs = nullptr;           // by triangle, from TextureRecord::first_uvs on
  const InstanceRecord* instances = nullptr;  // null: the scene has none
  bool two_uv_sets = false;                   // first_uvs of some texture is not 0
  bool empty() const { return records == nullptr; }
};

// Multiplies color of rows [0, n) whose material has a colour texture by it. `pixel_angle` is the
// angle of a pixel as the camera sees it [rad]; at 0 level 0 is always read. Padding rows may be
// written.
void TextureColors(const TextureView& textures, const MaterialRecord* materials, float pixel_angle,
                   std::uint32_t n, const SurfaceColumns& surfaces);

// Multiplies color of rows [0, n) by that of the triangle's corners, interpolated. `colors` has
// three per triangle (PackTexel).
void TintByVertices(const std::uint32_t* colors, std::uint32_t n, const SurfaceColumns& surfaces);

// Writes Varying::kRoughness of rows [0, n), which are metallic-roughness: the material's
// parameters times its roughness texture (green squared and blue) if it has one. `textures` may be
// empty.
// For Varying::kAlpha, the second column then means nothing.
void PrepareMetallicRoughness(const TextureView& textures, const MaterialRecord* materials,
                              float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces);

// Writes Varying::kCoatWidths of rows [0, n), which are coated conductors: the material's widths,
// times its roughness texture (green and red squared) if it has one.
void PrepareCoatWidths(const TextureView& textures, const MaterialRecord* materials,
                       float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces);

// Does what PrepareMetallicRoughness does for surfaces of which some have two widths, after
// PrepareTangents: varying_0 becomes the width along the tangent, and varying_1 the FacetTurn
// (kernels/surface/facet_turn-inl.h). `across` is the field of materials that has the width across
// it, 0 where there is only one. With `only_textured`, rows without a texture of their widths stay
// as they are.
void PrepareTwoWidths(const TextureView& textures, const MaterialRecord* materials,
                      MaterialField across, bool only_textured, float pixel_angle, std::uint32_t n,
                      const SurfaceColumns& surfaces);

// Writes Varying::kSecondColor of rows [0, n): the texture, or 1 where there is none.
void PrepareSecondColor(const TextureView& textures, const MaterialRecord* materials,
                        float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces);

// Returns the first channel of a texture at barycentric (u, v) of a triangle, at level 0, with the
// bits that vector lookups give there.
float FirstChannel(const TextureView& textures, std::uint32_t texture, std::uint32_t triangle,
                   float u, float v);

inline constexpr float kBrightestTexel = 511;  // largest value that PackTexel can hold

// Packs three channels of nine bits and a common exponent; the error is at most 2^-9 of the
// brightest channel. Negative values and NaN become 0, larger values kBrightestTexel.
std::uint32_t PackTexel(const float* rgb);

}  // namespace skywave
