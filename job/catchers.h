// The option `catcher`, which makes surfaces of a scene catchers (Material::catcher).
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Makes catchers of all materials and meshes of these names, meshes of objects included. A mesh
// gets a material of its own. Throws OptionError for a name that nothing has, with the nearest
// ones.
void MakeCatchers(const std::vector<std::string>& names, Scene& scene);

}  // namespace skywave
