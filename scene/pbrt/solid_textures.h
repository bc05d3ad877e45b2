// Textures that are functions of the place or of the normal. solid_baking.h evaluates them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/materials/texture_baking.h"
#include "scene/pbrt/state.h"

namespace skywave {

// These read what chooses between the operands of a checkerboard of dimension 3 (0 or 1) and of a
// directionmix (0 to 1), and the classes marble, and noise: fbm, windy and wrinkled.
PbrtTexture ReadSolidChecks(PbrtReader& reader, const PbrtParameters& parameters);
PbrtTexture ReadDirection(PbrtReader& reader, PbrtParameters& parameters);
PbrtTexture ReadMarble(PbrtReader& reader, PbrtParameters& parameters);
PbrtTexture ReadNoise(PbrtReader& reader, PbrtParameters& parameters, const std::string& kind);

// Returns what `combine` makes of textures of which one at least varies in space; others may be
// images over the (u, v) of the shape. It has no value, with a warning, if it would take more than
// kMaxPbrtEvaluations.
PbrtTexture CombineInSpace(PbrtReader& reader, const PbrtParameters& parameters,
                           const std::vector<PbrtTexture>& textures, const CombineTexels& combine);

// Returns whether a mapping has (u, v) by the place, and not by those of the shape: "planar",
// "spherical" and "cylindrical".
bool IsPbrtMappingInSpace(std::string_view mapping);

// Returns a texture over (u, v) laid in the space in which it is defined by such a mapping: over
// the plane of the vectors "v1" and "v2", or around the z axis. One without an image stays as it
// is.
PbrtTexture LayInSpace(PbrtReader& reader, PbrtParameters& parameters, std::string_view mapping,
                       const PbrtTexture& texture);

}  // namespace skywave
