// Converts glTF's materials to Skywave's.
//
//   pbrMetallicRoughness             metallic-roughness: factors and both textures
//   KHR_materials_ior                its index
//   KHR_materials_transmission       a factor of at least 1/2 makes a pane of the base colour
//   KHR_materials_volume             (with transmission, thickness above 0) a dielectric, smooth or
//                                    rough, that absorbs by attenuationColor and
//                                    attenuationDistance
//   KHR_materials_clearcoat, _sheen  layers (kernels/bsdf/coat-inl.h), by their factors
//   KHR_materials_specular           a lower index that reflects less
//   KHR_materials_unlit              Lambert, with a warning
//   KHR_texture_transform            offset, rotation and scale
//   alphaMode MASK, BLEND            alpha: a cutoff, or the fraction of rays that is stopped
//   normalTexture                    with its scale, along TANGENT or else the axes of the uvs
//   emissiveFactor, emissiveTexture, KHR_materials_emissive_strength
//                                    radiance in nits, on both sides of doubleSided materials. The
//                                    texture is looked up at every hit; its mean over a triangle
//                                    decides only how often that is sampled. Parts cut out by alpha
//                                    do not emit
//
// Both sides of every surface are rendered, doubleSided or not: a side that cannot be seen would
// still have to cast shadows, and path tracers show it (Cycles does).
//
// Occlusion textures are ignored without a warning because rendering computes occlusion. Texture
// filtering is Skywave's own, whatever a sampler asks for.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

struct GltfMaterials {
  // Holds the uv set of each material's textures, by index in the file; the material of primitives
  // without one comes last.
  std::vector<int> uv_set;
  std::vector<bool> uses_tangents;  // likewise, whether a material has a normal map
};

// Appends the materials of the file and then the default one to scene.materials, in order, with
// their textures and images. Throws InputError(path).
GltfMaterials AddGltfMaterials(const tinygltf::Model& model, const std::string& path, Scene& scene,
                               Warnings& warnings);

}  // namespace skywave
