// Reads alpha, normal maps and height maps of pbrt's shapes and materials.
#pragma once

#include "scene/pbrt/state.h"

namespace skywave {

// Adds a copy of a texture of the scene with another use, and returns its index.
std::uint32_t CopyPbrtTexture(PbrtReader& reader, std::uint32_t texture, TextureUse use);

// Reads the float or texture "alpha" of a shape: rays hit the shape where it is 1, pass where it is
// 0, and hit with that probability in between. Returns the material for this shape: `material`
// itself or a copy of it.
std::uint32_t MaterialWithPbrtAlpha(PbrtReader& reader, PbrtParameters& parameters,
                                    std::uint32_t material);

// Reads the normal map of a material ("normalmap", a file) or its heights ("displacement" or
// "bumpmap", a texture in units of length). Only the shading normals change, not the shapes.
void ReadPbrtRelief(PbrtReader& reader, PbrtParameters& parameters, Material& material);

}  // namespace skywave
