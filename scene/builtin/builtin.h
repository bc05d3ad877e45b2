// Scenes that need no file: for a first picture, for tests and for measurements.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace skywave {

struct BuiltinSceneInfo {
  std::string_view name;
  std::string_view description;  // one line
};

std::span<const BuiltinSceneInfo> BuiltinScenes();

// Complete: meshes, materials, camera, light and settings; right-handed, y up. The same bits each
// time. Throws InputError that lists the scenes if there is none of that name.
Scene BuiltinScene(const std::string& name);

}  // namespace skywave
