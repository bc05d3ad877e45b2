// What shapes and materials of pbrt files say of holes and relief.
#pragma once

#include "scene/pbrt/state.h"

namespace skywave {

// The float or texture "alpha" of a shape: where it is 1 the shape is there, where it is 0 it is
// not, and rays pass in that share in between. Material `material` as it is for this shape: itself,
// or a copy.
std::uint32_t MaterialWithPbrtAlpha(PbrtReader& reader, PbrtParameters& parameters,
                                    std::uint32_t material);

// The normal map of a material ("normalmap", a file) or its heights ("displacement" or "bumpmap", a
// texture whose 1 is a length of 1): shapes stay as they are, their normals follow.
void ReadPbrtRelief(PbrtReader& reader, PbrtParameters& parameters, Material& material);

}  // namespace skywave
