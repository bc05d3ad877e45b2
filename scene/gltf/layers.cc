#include "scene/gltf/layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "scene/gltf/extensions.h"

namespace skywave {
namespace {

void SetSpecular(GltfTextures& context, const tinygltf::Value& extension, Material& material) {
  material.specular = GltfFractionOf(context, extension, "specularFactor", 1);
  material.specular_color =
      glm::clamp(GltfColor(extension, "specularColorFactor", glm::vec3(1)), 0.0f, 1e6f);
  material.specular_texture =
      GltfTextureOf(context, extension, "specularTexture", Encoding::kAlpha);
  material.specular_color_texture =
      GltfTextureOf(context, extension, "specularColorTexture", Encoding::kSrgb);
}

void SetFilm(GltfTextures& context, const tinygltf::Value& extension, Material& material) {
  const float factor = GltfFractionOf(context, extension, "iridescenceFactor", 0);
  if (!(factor > 0)) return;
  const GltfShare share =
      AddGltfShare(context, TextureInfo(extension, "iridescenceTexture"), 0, factor);
  material.film = share.number, material.film_texture = share.texture;
  material.film_ior = GltfPositive(context, extension, "iridescenceIor", 1.3);
  if (material.film_ior < 1) {
    WarnOfMaterial(context, fmt::format("iridescenceIor {} is below 1: 1 is used, which is no film",
                                        material.film_ior));
    material.film_ior = 1;
  }
  material.film_thin = GltfPositive(context, extension, "iridescenceThicknessMinimum", 100);
  material.film_thick = GltfPositive(context, extension, "iridescenceThicknessMaximum", 400);
  material.film_thickness_texture =
      GltfTextureOf(context, extension, "iridescenceThicknessTexture", Encoding::kLinear);
}

void SetAnisotropy(GltfTextures& context, const tinygltf::Value& extension, Material& material) {
  material.anisotropy = GltfFractionOf(context, extension, "anisotropyStrength", 0);
  material.anisotropy_turn = float(GltfNumber(extension, "anisotropyRotation", 0));
  if (!(std::abs(material.anisotropy_turn) <= 1e6f)) {
    WarnOfMaterial(context, "anisotropyRotation is not supported: 0 is used");
    material.anisotropy_turn = 0;
  }
  if (!(material.anisotropy > 0)) return;
  material.anisotropy_texture =
      GltfTextureOf(context, extension, "anisotropyTexture", Encoding::kLinear);
}

// Sets what only layered metallic-roughness has, in the part of a material that reflects. Factors
// that change nothing leave the material as it is.
void SetLayers(GltfTextures& context, const tinygltf::Material& from, Material& material) {
  SetGltfReflection(context, from, material);
  if (const auto* const extension = GltfExtension(from, khr::kAnisotropy)) {
    SetAnisotropy(context, *extension, material);
  }
  if (!material.reflects_plainly() || material.anisotropy > 0) {
    material.bsdf = BsdfKind::kLayeredMetallicRoughness;
  }
}

// Gives the coat normals of its own: those of its map, or none, where the base has another one. The
// surface then has the normals of the coat, and the base has its own below it.
void SetCoatNormals(GltfTextures& context, const tinygltf::Material& from,
                    const tinygltf::Value& extension, Material& coated) {
  const char* const name = "clearcoatNormalTexture";
  const GltfTextureInfo of_base = TextureInfo(from.normalTexture);
  const GltfTextureInfo own = TextureInfo(extension, name);
  const auto scale = float(own.index < 0 ? 1 : GltfNumber(extension.Get(name), "scale", 1));
  if (own == of_base && scale == coated.normal_scale) return;
  const auto map = AddGltfTexture(context, own, Encoding::kLinear, TextureUse::kNormals);
  if (!map && !coated.normal_texture) return;
  coated.own_base_normals = true;
  coated.base_normal_texture = std::exchange(coated.normal_texture, map);
  coated.base_normal_scale = std::exchange(coated.normal_scale, scale);
}

// Gives a material one more layer, of which `rich` says that it has textures or normals that only
// layered metallic-roughness reads.
void AddLayer(bool rich, Material& material) {
  if (rich || material.bsdf == BsdfKind::kLayeredMetallicRoughness) {
    material.bsdf = BsdfKind::kLayeredMetallicRoughness;
  } else {
    material.bsdf = BsdfKind::kCoatedMetallicRoughness;
  }
}

// Gives a part of a material its coat, and returns the share of the surface that has it: 0 without
// the extension.
GltfShare SetCoat(GltfTextures& context, const tinygltf::Material& from, Material& coated) {
  const auto* const coat = GltfExtension(from, khr::kClearcoat);
  const float strength = coat == nullptr ? 0 : GltfFractionOf(context, *coat, "clearcoatFactor", 0);
  if (!(strength > 0)) return {0};
  const GltfShare share =
      AddGltfShare(context, TextureInfo(*coat, "clearcoatTexture"), 0, strength);
  coated.coat = share.number;
  const float roughness = GltfFractionOf(context, *coat, "clearcoatRoughnessFactor", 0);
  coated.coat_alpha = roughness * roughness;
  if (roughness > 0) {
    coated.coat_alpha_texture =
        GltfTextureOf(context, *coat, "clearcoatRoughnessTexture", Encoding::kLinear);
  }
  SetCoatNormals(context, from, *coat, coated);
  return share;
}

// Returns the material under its coat, or a mixture of both where the coat is not everywhere.
Material PartlyCoated(GltfTextures& context, const Material& bare, const Material& coated,
                      const GltfShare& share) {
  if (!share.texture) return coated;
  return GltfMixture(context, bare, NamedPart(coated, "coated"), share);
}

}  // namespace

void SetGltfReflection(GltfTextures& context, const tinygltf::Material& from, Material& material) {
  if (const auto* const extension = GltfExtension(from, khr::kSpecular)) {
    SetSpecular(context, *extension, material);
  }
  if (const auto* const extension = GltfExtension(from, khr::kIridescence)) {
    SetFilm(context, *extension, material);
  }
}

Material LayeredGltf(GltfTextures& context, const tinygltf::Material& from, Material base) {
  SetLayers(context, from, base);
  if (const auto* const sheen = GltfExtension(from, khr::kSheen)) {
    const glm::vec3 color = GltfColor(*sheen, "sheenColorFactor", glm::vec3(0));
    for (int c = 0; c < 3; ++c) base.sheen[c] = GltfFraction(context, "sheenColorFactor", color[c]);
    const float roughness = GltfFractionOf(context, *sheen, "sheenRoughnessFactor", 0);
    base.sheen_alpha = roughness * roughness;
    if (base.sheen != glm::vec3(0)) {
      base.sheen_texture = GltfTextureOf(context, *sheen, "sheenColorTexture", Encoding::kSrgb);
      base.sheen_alpha_texture =
          GltfTextureOf(context, *sheen, "sheenRoughnessTexture", Encoding::kAlpha);
      AddLayer(base.sheen_texture || base.sheen_alpha_texture, base);
    }
  }
  base.coat = 0;
  Material coated = base;
  const GltfShare share = SetCoat(context, from, coated);
  if (!(share.number > 0)) return base;
  AddLayer(coated.coat_alpha_texture || coated.own_base_normals, coated);
  return PartlyCoated(context, base, coated, share);
}

Material CoatedGltfGlass(GltfTextures& context, const tinygltf::Material& from, Material glass) {
  Material coated = glass;
  const GltfShare share = SetCoat(context, from, coated);
  if (!(share.number > 0)) return glass;
  const bool solid =
      glass.bsdf == BsdfKind::kDielectric || glass.bsdf == BsdfKind::kRoughDielectric;
  if (solid && glass.ior <= 1.001f) {
    WarnOfMaterial(context, "KHR_materials_clearcoat: what has the index of air has no coat");
    return glass;
  }
  // Smooth glass gets the narrowest facets, because the coat needs a density.
  coated.bsdf = solid ? BsdfKind::kCoatedRoughDielectric : BsdfKind::kCoatedRoughThinDielectric;
  if (coated.coat_alpha_texture) {
    coated.coat_alpha_texture.reset();
    WarnOfMaterial(context,
                   "clearcoatRoughnessTexture: the coat of what transmits has the factor alone");
  }
  return PartlyCoated(context, glass, coated, share);
}

}  // namespace skywave
