// Materials of glTF that let light through: glass, panes, and sheets.
#pragma once

#include <tiny_gltf.h>

#include "kernels/bsdf/material.h"
#include "scene/gltf/textures.h"

namespace skywave {

// Returns whether a material has an extension by which it may let light through.
bool GltfTransmits(const tinygltf::Material& from);

// Returns what glTF calls the material, a mix of metal and dielectric by `metallic`. The dielectric
// is a mix of glass and a body by the transmission, and the body one of a sheet and an opaque one
// by the diffuse transmission.
Material TransmittingGltf(GltfTextures& context, const tinygltf::Material& from, Material base);

}  // namespace skywave
