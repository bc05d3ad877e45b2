// Loads a glTF file: the container, its buffers from wherever they lie, what is compressed, and
// then its JSON with tinygltf.
#pragma once

#include <tiny_gltf.h>

#include <string>

#include "scene/warnings.h"

namespace skywave {

// Returns the model of a .gltf or .glb file of these bytes. Buffers are complete and uncompressed,
// images still encoded; nothing else of it has been checked. Primitives that cannot be decompressed
// are left out with a warning. Throws InputError(path) for files of another version, for required
// extensions that are not supported, and for names that lead out of the file's folder.
tinygltf::Model LoadGltf(const std::string& bytes, const std::string& path, Warnings& warnings);

}  // namespace skywave
