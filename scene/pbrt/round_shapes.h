// The shapes that pbrt intersects itself, which are meshes of patches here: sphere, disk, cylinder,
// and cone, paraboloid and hyperboloid, which pbrt-v4 has no longer.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "scene/pbrt/parameters.h"
#include "scene/scene.h"

namespace skywave {

bool IsRoundPbrtShape(std::string_view type);

// Returns the numbers that make the form of a round shape, without the radius of a whole sphere,
// which is taken out of the parameters: the sphere of radius 1 has a scale then.
struct PbrtRoundNumbers {
  std::vector<std::optional<float>> numbers;
  float scale = 1;
};
PbrtRoundNumbers FindRoundNumbers(std::string_view type, PbrtParameters& parameters);

// Returns the mesh of a round shape in its own space, with texture coordinates if they are needed.
// Warns where pbrt has another surface. Throws InputError on numbers that make none.
Mesh MakeRoundPbrtShape(std::string_view type, PbrtParameters& parameters, bool needs_uvs,
                        Warnings& warnings);

}  // namespace skywave
