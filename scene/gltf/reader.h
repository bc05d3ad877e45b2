// Reads glTF 2.0 files, .gltf and .glb (gltf/document.h).
//
// The reader takes the triangles of the default scene (or the first one, or all nodes without a
// parent if there is no scene), with every instance as a copy; its cameras, each named after its
// node or else by itself, followed by #NODE if two have the same name; its punctual lights; and the
// materials described in gltf/materials.h. If a frame is asked for, nodes are where the animations
// have them then (gltf/animation.h). The world is right-handed with y up. Buffers and images lie in
// the file, in data: URIs or in files below its folder; absolute paths and paths with .. are
// refused. Skins are where their joints are (gltf/skins.h). Points and lines are left out.
#pragma once

#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// Throws InputError on any inconsistency: indices and ranges outside their targets, nodes that are
// their own ancestors, required extensions that are unknown. Warnings name everything that is not
// rendered.
Scene ReadGltf(const std::string& path, const ReadOptions& options = {});

// Parses the same from memory; other files are looked up relative to `path`.
Scene ParseGltf(const std::string& bytes, const std::string& path, const ReadOptions& options = {});

}  // namespace skywave
