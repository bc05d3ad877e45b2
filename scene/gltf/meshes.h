// Builds meshes from the triangles of a glTF file.
#pragma once

#include <tiny_gltf.h>

#include <string>
#include <vector>

#include "scene/gltf/materials.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// Returns one untransformed mesh per primitive: triangles, strips and fans. Primitives without
// normals are shaded flat, as glTF requires. Throws InputError(path).
std::vector<Mesh> MakeGltfMeshes(const tinygltf::Model& model, int mesh,
                                 const GltfMaterials& materials, const std::string& path,
                                 Warnings& warnings);

}  // namespace skywave
