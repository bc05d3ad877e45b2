// The built-in scenes need no file: they serve for a first picture, for tests and for measurements.
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

// Returns a complete scene: meshes, materials, camera, light and settings, right-handed with y up.
// The result is bit-identical on every call. Throws InputError that lists the scenes if none has
// that name.
Scene BuiltinScene(const std::string& name);

}  // namespace skywave
