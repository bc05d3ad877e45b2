// The options `catcher` and `holdout`, which mark surfaces of a scene by their names.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Sets `mark` in all materials and for all meshes of these names, meshes of objects included. A
// mesh gets a material of its own. Throws OptionError of `option` for a name that nothing has, with
// the nearest ones.
void Mark(const std::string& option, const std::vector<std::string>& names, bool Material::*mark,
          Scene& scene);

}  // namespace skywave
