// The layers of glTF's materials: coats, sheen, and those of layered metallic-roughness.
#pragma once

#include <tiny_gltf.h>

#include "kernels/bsdf/material.h"
#include "scene/gltf/textures.h"

namespace skywave {

// Returns the base with all its layers, under its sheen and its coat. A coat that is not everywhere
// is a mixture, as the extension's layer is linear in its strength.
Material LayeredGltf(GltfTextures& context, const tinygltf::Material& from, Material base);

// Gives a part of a material what its dielectric reflects by KHR_materials_specular and
// KHR_materials_iridescence.
void SetGltfReflection(GltfTextures& context, const tinygltf::Material& from, Material& material);

// Returns the glass under its coat, if it has one.
Material CoatedGltfGlass(GltfTextures& context, const tinygltf::Material& from, Material glass);

}  // namespace skywave
