// glTF 2.0 files, .gltf and .glb, read by tinygltf.
//
// Rendered are the triangles of the default scene (the first one, or all nodes without a parent,
// where the file names none), every instance on its own; its first camera, else none; and materials
// as in gltf_materials.h. The world is right-handed and y is up; glTF has no light of ours.
// Buffers and images lie in the file, in data: URIs or in files below its folder: absolute paths
// and such with .. are refused. Animation, skins, morph targets, points and lines are left out.
#pragma once

#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// Throws InputError on everything that contradicts itself: indices and ranges outside of what they
// are of, nodes that are their own ancestors, required extensions that are not known. Warnings say
// what is not rendered.
Scene ReadGltf(const std::string& path, const ReadOptions& options = {});

// The same from memory; other files are looked up beside `path`.
Scene ParseGltf(const std::string& bytes, const std::string& path, const ReadOptions& options = {});

}  // namespace skywave
