// Converts glTF's materials to Skywave's.
//
//   pbrMetallicRoughness             metallic-roughness: factors and both textures
//   KHR_materials_ior                its index
//   KHR_materials_transmission       a share of glass, by its factor, its texture and what is not
//                                    metal: a mixture. Glass transmits in the base colour and
//                                    reflects white; without a volume it is a pane, whose surface
//                                    reflects once
//   KHR_materials_volume             (with transmission, thickness above 0) a dielectric that
//                                    absorbs by attenuationColor and attenuationDistance
//   KHR_materials_diffuse_transmission
//                                    a share of a sheet that lets light through diffusely
//                                    (kernels/bsdf/coated_diffuse_transmission.cc), with its
//                                    textures
//   KHR_materials_clearcoat          a coat (kernels/bsdf/coat-inl.h) with its textures, of the
//                                    normals of the base
//   KHR_materials_sheen              sheen with its textures
//   KHR_materials_specular, KHR_materials_anisotropy, KHR_materials_iridescence
//                                    those of layered metallic-roughness
//                                    (kernels/bsdf/layered_metallic_roughness.cc), of what does not
//                                    transmit
//   KHR_materials_pbrSpecularGlossiness
//                                    converted (scene/gltf/specular_glossiness.h)
//   KHR_materials_unlit              black, of the radiance of its base colour; with colours of
//                                    vertices Lambert, with a warning
//   KHR_materials_variants           the materials of the file, or of the variant that is asked for
//   KHR_texture_transform            offset, rotation and scale
//   alphaMode MASK, BLEND            alpha: a cutoff, or the fraction of rays that is stopped
//   normalTexture                    with its scale, along TANGENT or else the axes of the uvs
//   emissiveFactor, emissiveTexture, KHR_materials_emissive_strength
//                                    radiance in nits, on both sides of doubleSided materials. The
//                                    texture is looked up at every hit; its mean over a triangle
//                                    decides only how often that is sampled. Parts cut out by alpha
//                                    do not emit
//
// doubleSided: camera rays pass through the back of what is not, unless it transmits. All other
// rays, of shadows, reflections and scattered light, meet both sides.
//
// Occlusion textures are ignored without a warning because rendering computes occlusion. Textures
// are filtered in Skywave's own way, except that a magFilter of NEAREST is honoured.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scene/gltf/textures.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// What meshes need to know of a material.
struct GltfMaterial {
  std::uint32_t row = 0;       // in Scene::materials
  std::vector<int> uv_sets;    // of its textures, two at most (UvSet)
  bool uses_tangents = false;  // it has a normal map or a grain
  bool grained = false;        // KHR_materials_anisotropy
  bool opaque = true;          // its alpha counts for nothing
};

// The materials of a file, each of which is added to the scene when it is first used, with its
// textures and images: what nothing uses is not decoded, and cannot be wrong.
class GltfMaterials {
 public:
  // All of these outlive it.
  GltfMaterials(const tinygltf::Model& model, const std::string& path, Scene& scene,
                Warnings& warnings);

  // Takes the materials of a variant (KHR_materials_variants) from here on; -1: those of the file.
  void ChooseVariant(int variant) { variant_ = variant; }
  // Returns the material of a primitive. Throws InputError(path) where the file has none of its
  // index.
  const GltfMaterial& Of(const tinygltf::Primitive& primitive);
  // Decodes the images of the materials of these primitives on all threads, before they are asked
  // for; Of would decode one after the other.
  void DecodeImagesOf(std::span<const tinygltf::Primitive* const> primitives);

 private:
  // Returns the index of a primitive's material in the file; below 0, it names none.
  int IndexOf(const tinygltf::Primitive& primitive) const;

  GltfTextures textures_;
  // By the index in the file, and whether the primitive of an unlit one has colours of vertices.
  std::map<std::pair<int, bool>, GltfMaterial> used_;
  int variant_ = -1;
};

// Returns the names of the variants of a file's materials, in its order.
std::vector<std::string> GltfVariants(const tinygltf::Model& model);

}  // namespace skywave
