// The triangles of a glTF file.
#pragma once

#include <tiny_gltf.h>

#include <string>
#include <vector>

#include "scene/gltf/materials.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// One mesh a primitive, not yet transformed. Triangles, strips and fans; primitives without normals
// are flat, as glTF wants it. Throws InputError(path).
std::vector<Mesh> MakeGltfMeshes(const tinygltf::Model& model, int mesh,
                                 const GltfMaterials& materials, const std::string& path,
                                 Warnings& warnings);

}  // namespace skywave
