// The skins of a glTF file, which move the vertices of meshes by joints (glTF 2.0, 3.7.3).
#pragma once

#include <tiny_gltf.h>

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// World from rest of each joint: its node's transform times its inverse bind matrix. The transform
// of the node that has the mesh does not count.
struct GltfSkin {
  std::vector<glm::dmat4> joints;
};

// `worlds` are the transforms of all nodes. Throws InputError(path) for a skin or joints that do
// not exist, and for too few matrices.
GltfSkin MakeGltfSkin(const tinygltf::Model& model, int index,
                      const std::vector<glm::dmat4>& worlds, const std::string& path);

// Moves positions, normals and tangents of the mesh of a primitive to the world, each vertex by the
// mean of its joints by their weights: any number of sets of four. Weights that do not add up to 1
// are normalised with a warning; vertices without weights follow the first joint. Where the joints
// mirror, the triangles turn round. Throws InputError(path) for joints that the skin does not have
// and for attributes of another length.
void SkinGltfMesh(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                  const GltfSkin& skin, const std::string& path, Mesh& mesh, Warnings& warnings);

}  // namespace skywave
