// Options that mark surfaces of a scene by their names: `catcher`, `holdout` and links of lights.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// A mark is a flag or a bit of materials: set(material) sets it, and is_set(material) returns
// whether it is set.
struct MaterialMark {
  std::function<void(Material&)> set;
  std::function<bool(const Material&)> is_set;
};
MaterialMark FlagOf(bool Material::*flag);
MaterialMark BitOf(std::uint32_t Material::*bits, std::uint32_t bit);

// Sets `mark` in all materials and for all meshes of these names, meshes of objects included. A
// mesh gets a material of its own. Throws OptionError of `option` for a name that nothing has, with
// the nearest ones.
void Mark(const std::string& option, const std::vector<std::string>& names,
          const MaterialMark& mark, Scene& scene);

}  // namespace skywave
