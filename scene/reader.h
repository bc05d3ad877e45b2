// The one door to a scene: a file by its ending, or a built-in scene by its name.
#pragma once

#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// .pbrt (pbrt_reader.h), .obj (obj_reader.h), .gltf and .glb (gltf_reader.h) and .ply (ply.h: one
// mesh of grey Lambert); the ending in any case, .pbrt and .ply also with .gz behind. A `path` that
// is no file may name a built-in scene (builtin.h). Throws InputError for other endings, and,
// listing the built-in scenes, where there is neither file nor scene.
Scene ReadScene(const std::string& path, const ReadOptions& options = {});

}  // namespace skywave
