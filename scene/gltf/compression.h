// Decompresses the geometry of a glTF document: KHR_draco_mesh_compression by libdraco, and
// EXT_ and KHR_meshopt_compression by libmeshoptimizer. Accessors then find their numbers in new
// buffers.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene/warnings.h"

namespace skywave {

// A glTF file's JSON and the bytes of its buffers.
struct GltfSource {
  nlohmann::json json;
  std::vector<std::string> buffers;
};

// Both warn of what cannot be decoded, which is left out. They throw an exception of the JSON
// library where a type is not what it has to be.
void DecodeMeshoptViews(GltfSource& source, const std::string& path, Warnings& warnings);
void DecodeDracoPrimitives(GltfSource& source, const std::string& path, Warnings& warnings);

}  // namespace skywave
