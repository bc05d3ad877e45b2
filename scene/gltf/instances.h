// The instances of a glTF node (EXT_mesh_gpu_instancing).
#pragma once

#include <tiny_gltf.h>

#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace skywave {

// Returns whether the node has the extension.
bool HasGltfInstances(const tinygltf::Node& node);

// Returns the places of the node's mesh in the node's space, T * R * S each: those of the
// extension, or one identity. Throws InputError(path) for attributes that are not accessors of
// vectors, or have different lengths, and for more than kMaxInstances.
std::vector<glm::dmat4> GltfInstances(const tinygltf::Model& model, const tinygltf::Node& node,
                                      const std::string& path);

}  // namespace skywave
