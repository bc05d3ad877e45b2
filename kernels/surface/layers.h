// The textures of layered metallic-roughness, and of the layers of glass, at a hit.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/texture.h"

namespace skywave {

// Writes Varying::kLayers of rows [0, n). PrepareTangents has written these rows before with the
// same `tangents`; if they are null, no material has a grain. `textures` may be empty.
void PrepareLayers(const TextureView& textures, const MaterialRecord* materials,
                   const std::uint32_t* tangents, float pixel_angle, std::uint32_t n,
                   const SurfaceColumns& surfaces);

// Writes what the textures of glass say to varying_2 and varying_3 of rows [0, n), whose BSDF has
// BsdfTraits::glass_layers. `textures` may be empty.
void PrepareGlassLayers(const TextureView& textures, const MaterialRecord* materials,
                        float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces);

}  // namespace skywave
