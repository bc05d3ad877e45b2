// Builds meshes from the triangles of a glTF file.
#pragma once

#include <tiny_gltf.h>

#include <string>
#include <vector>

#include "scene/gltf/materials.h"
#include "scene/gltf/skins.h"
#include "scene/read_options.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// Returns why a primitive of a mesh of the file is left out, or nothing where it is not.
std::string WhyLeftOut(const tinygltf::Model& model, int mesh, const tinygltf::Primitive& primitive,
                       const ReadOptions& options);

// Returns one mesh per primitive: triangles, strips and fans, and points and lines where `options`
// have a size for them, moved by morph targets of these weights and then, unless `skin` is null, by
// its joints, which put them in the world. Triangles without normals are shaded flat, as glTF
// requires. What is left out gets a warning (WhyLeftOut). Throws InputError(path).
std::vector<Mesh> MakeGltfMeshes(const tinygltf::Model& model, int mesh,
                                 const std::vector<double>& weights, const GltfSkin* skin,
                                 const ReadOptions& options, GltfMaterials& materials,
                                 const std::string& path, Warnings& warnings);

}  // namespace skywave
