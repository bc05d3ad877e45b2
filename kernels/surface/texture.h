// Image textures: the colours of surfaces, and the parameters of metallic-roughness materials.
//
// Lookups are bilinear in one level of the mip pyramid. The level is that whose texels are as large
// as a cone of `pixel_angle` over the length of the ray (Akenine-Moller et al. 2021, "Improved
// Shader and Texture Level of Detail Using Ray Cones", Section 3): the geometric mean of both axes
// of the ellipse, rounded down. The cone starts anew at every surface, so textures behind mirrors
// and seen by scattered light are sharper than need be, never more blurred.
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

// All null in scenes without textures.
struct TextureView {
  const TextureRecord* records = nullptr;
  const TextureLevel* levels = nullptr;
  const std::uint32_t* texels = nullptr;  // PackTexel, row by row from the top
  const TriangleUvs* uvs = nullptr;       // by triangle
  bool empty() const { return records == nullptr; }
};

// Multiplies color of rows [0, n) whose material has a colour texture by it. `pixel_angle`: of a
// pixel as the camera sees it [rad]; 0: always level 0. Padding rows may be written.
void TextureColors(const TextureView& textures, const MaterialRecord* materials, float pixel_angle,
                   std::uint32_t n, const SurfaceColumns& surfaces);

// Multiplies color of rows [0, n) by that of the triangle's corners, interpolated. `colors`: three
// a triangle (PackTexel).
void TintByVertices(const std::uint32_t* colors, std::uint32_t n, const SurfaceColumns& surfaces);

// Writes Varying::kRoughness of rows [0, n), which are metallic-roughness: that of the material,
// times roughness texture (green squared and blue) where there is one. `textures` may be empty.
void PrepareMetallicRoughness(const TextureView& textures, const MaterialRecord* materials,
                              float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces);

// The first channel of a texture at barycentric (u, v) of a triangle, at level 0: the bits that
// lookups by vectors give there.
float FirstChannel(const TextureView& textures, std::uint32_t texture, std::uint32_t triangle,
                   float u, float v);

inline constexpr float kBrightestTexel = 511;  // that PackTexel can hold

// Three channels of nine bits and an exponent in common: off by at most 2^-9 of the brightest
// channel. Negative values and NaN become 0, what exceeds kBrightestTexel is that.
std::uint32_t PackTexel(const float* rgb);

}  // namespace skywave
