// Converts KHR_materials_pbrSpecularGlossiness to metallic-roughness.
//
// Both models have a diffuse and a specular colour. Of a metal m and a base colour b, these are
// (1 - m) b and (1 - m) 0.04 + m b; what light the specular lobe takes from the diffuse one differs
// as well. The share of metal is the one for which both colours give the same b, by brightness:
//   0.04 m^2 + (D (1 - S) / 0.96 + S' - 0.08) m + 0.04 - S' = 0
// where D and S' are the brightness of the diffuse and the specular colour, and S is the largest
// channel of the latter. The base colour is between those that either colour gives, by m^2.
// Textures are converted texel by texel.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>

#include "kernels/bsdf/material.h"
#include "scene/gltf/textures.h"

namespace skywave {

inline constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

// Sets reflectance, width, metal and their textures. Throws InputError(path).
void SetSpecularGlossiness(GltfTextures& textures, const tinygltf::Value& extension,
                           Material& material);

// Returns the alpha of its diffuse factor.
double SpecularGlossinessAlpha(const tinygltf::Value& extension);

}  // namespace skywave
