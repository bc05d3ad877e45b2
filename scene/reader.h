// The single entry point for scenes: a file by its extension, or a built-in scene by its name.
#pragma once

#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// Reads .pbrt (pbrt/reader.h), .obj (obj/reader.h), .gltf and .glb (gltf/reader.h) and .ply
// (shapes/ply.h: one mesh of grey Lambert). The extension may be in any case; .pbrt and .ply may be
// followed by .gz. If `path` is not a file, it may name a built-in scene (builtin/builtin.h).
// Throws InputError for other extensions, and, listing the built-in scenes, if there is neither
// file nor scene; OptionError, listing the animations, if the scene has none of the name asked for.
Scene ReadScene(const std::string& path, const ReadOptions& options = {});

// Returns the endings of the files that ReadScene reads, ".pbrt, .obj, ... or .ply".
std::string SceneEndings();

}  // namespace skywave
