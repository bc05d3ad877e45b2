// glTF's materials as Skywave's.
//
//   pbrMetallicRoughness           metallic-roughness: factors and both textures
//   KHR_materials_ior              its index
//   KHR_materials_transmission     from a factor of 1/2: a pane of the base colour, or with
//   KHR_materials_volume           (thickness above 0) a dielectric, smooth or rough; no absorption
//   KHR_materials_clearcoat, KHR_materials_sheen   layers (kernels/bsdf/coat-inl.h), by their
//   factors KHR_materials_specular         the index that reflects so much KHR_materials_unlit
//   Lambert, with a warning KHR_texture_transform          offset, rotation and scale alphaMode
//   MASK, BLEND          holes by alphaCutoff, or in the share of rays that alpha leaves
//   normalTexture                  with its scale, along TANGENT or else the axes of the uvs
//   emissiveFactor, emissiveTexture, KHR_materials_emissive_strength
//                                  radiance in nits, on both sides of doubleSided materials; of the
//                                  texture each triangle takes the mean; holes do not shine
//
// Both sides of every surface are rendered, doubleSided or not: a side that cannot be seen would
// still have to cast shadows, and path tracers show it (Cycles does).
//
// Occlusion is left out in silence: it is what rendering finds out. Filters of samplers are ours.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

struct GltfMaterials {
  // By material of the file, and behind them the one of primitives that have none: the set of
  // texture coordinates that its textures use.
  std::vector<int> uv_set;
  std::vector<bool> uses_tangents;  // likewise: whether it has a normal map
};

// Appends the materials of the file and the default one to scene.materials, in their order, with
// their textures and images. Throws InputError(path).
GltfMaterials AddGltfMaterials(const tinygltf::Model& model, const std::string& path, Scene& scene,
                               Warnings& warnings);

}  // namespace skywave
