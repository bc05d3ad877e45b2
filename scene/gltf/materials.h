// The materials of glTF as Skywave renders them.
//
//   pbrMetallicRoughness           metallic-roughness: factors and both textures
//   KHR_materials_ior              its index
//   KHR_materials_transmission     from a factor of 1/2: a pane of the base colour
//   KHR_materials_volume           with a thickness above 0: a dielectric, smooth or rough, which
//                                  absorbs by attenuationColor and attenuationDistance
//   KHR_materials_clearcoat        a layer (kernels/bsdf/coat-inl.h), by its factors
//   KHR_materials_sheen            likewise
//   KHR_materials_specular         the index that reflects so much
//   KHR_materials_unlit            Lambert, with a warning
//   KHR_texture_transform          offset, rotation and scale
//   alphaMode MASK, BLEND          holes by alphaCutoff, or in the share of rays that alpha leaves
//   normalTexture                  with its scale, along TANGENT or else the axes of the uvs
//   emissiveFactor, emissiveTexture, KHR_materials_emissive_strength
//                                  radiance in nits, on both sides of doubleSided materials. Rays
//                                  and light samples look the texture up where they meet it; its
//                                  mean over a triangle decides only how often that is sampled.
//                                  Holes do not emit.
//
// Both sides of every surface are rendered, doubleSided or not: a side that cannot be seen would
// still have to cast shadows, and path tracers show it (Cycles does).
//
// The reader leaves out occlusion without a remark, because rendering computes it. It ignores the
// filters of samplers: lookups have the renderer's own.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

struct GltfMaterials {
  // The set of texture coordinates that the textures of a material use, by material of the file;
  // the last one is that of primitives that have none.
  std::vector<int> uv_set;
  std::vector<bool> uses_tangents;  // likewise, whether a material has a normal map
};

// Appends the materials of the file and the default one to scene.materials, in their order, with
// their textures and images. Throws InputError(path).
GltfMaterials AddGltfMaterials(const tinygltf::Model& model, const std::string& path, Scene& scene,
                               Warnings& warnings);

}  // namespace skywave
