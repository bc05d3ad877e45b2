#include "scene/gltf/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "base/error.h"
#include "scene/gltf/extensions.h"
#include "scene/gltf/layers.h"
#include "scene/gltf/specular_glossiness.h"
#include "scene/gltf/textures.h"
#include "scene/gltf/transmission.h"
#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

// The extensions of materials, and the textures of them that are rendered.
struct KnownExtension {
  std::string_view name;
  std::vector<std::string_view> textures = {};
};
const KnownExtension kMaterialExtensions[] = {
    {"KHR_materials_ior"},
    {khr::kTransmission, {"transmissionTexture"}},
    {khr::kDiffuseTransmission, {"diffuseTransmissionTexture", "diffuseTransmissionColorTexture"}},
    {khr::kUnlit},
    // A thickness is for renderers that do not trace rays through the volume.
    {khr::kVolume, {"thicknessTexture"}},
    {khr::kClearcoat, {"clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"}},
    {khr::kSheen, {"sheenColorTexture", "sheenRoughnessTexture"}},
    {khr::kSpecular, {"specularTexture", "specularColorTexture"}},
    {khr::kAnisotropy, {"anisotropyTexture"}},
    {khr::kIridescence, {"iridescenceTexture", "iridescenceThicknessTexture"}},
    {"KHR_materials_emissive_strength"},
    {kSpecularGlossiness, {"diffuseTexture", "specularGlossinessTexture"}},
};

void WarnOfWhatIsLeftOut(GltfTextures& context, const tinygltf::Material& from) {
  for (const auto& entry : from.extensions) {
    const auto& [name, value] = entry;
    const auto known =
        std::find_if(std::begin(kMaterialExtensions), std::end(kMaterialExtensions),
                     [&](const auto& extension) { return extension.name == entry.first; });
    if (known == std::end(kMaterialExtensions)) {
      WarnOfMaterial(context, fmt::format("the extension {} is not supported: left out", name));
      continue;
    }
    for (const std::string& key : value.IsObject() ? value.Keys() : std::vector<std::string>()) {
      const auto& rendered = known->textures;
      if (!key.ends_with("Texture") || std::count(rendered.begin(), rendered.end(), key) != 0) {
        continue;
      }
      WarnOfMaterial(
          context,
          fmt::format("{} of {} is not supported: its factor is used everywhere", key, name));
    }
  }
}

// Returns the parameters that all parts of a material share, with their textures: those of
// metallic-roughness.
Material BaseOf(GltfTextures& context, const tinygltf::Material& from) {
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  Material base = {.name = from.name, .bsdf = BsdfKind::kMetallicRoughness};
  if (const auto* const extension = GltfExtension(from, kSpecularGlossiness)) {
    SetSpecularGlossiness(context, *extension, base);
  } else {
    for (std::size_t c = 0; c < 3; ++c) {
      const double factor = c < pbr.baseColorFactor.size() ? pbr.baseColorFactor[c] : 1;
      base.reflectance[int(c)] = GltfFraction(context, "baseColorFactor", factor);
    }
    const float roughness = GltfFraction(context, "roughnessFactor", pbr.roughnessFactor);
    base.alpha = roughness * roughness;
    base.metallic = GltfFraction(context, "metallicFactor", pbr.metallicFactor);
    base.color_texture = AddGltfTexture(context, TextureInfo(pbr.baseColorTexture), Encoding::kSrgb,
                                        TextureUse::kColor);
    base.roughness_texture = AddGltfTexture(context, TextureInfo(pbr.metallicRoughnessTexture),
                                            Encoding::kLinear, TextureUse::kColor);
  }
  if (const auto* const extension = GltfExtension(from, "KHR_materials_ior")) {
    base.ior = float(GltfNumber(*extension, "ior", 1.5));
    if (!(base.ior >= 1 && base.ior <= 100)) {
      // In old files, 0 stands for a coat that reflects everything.
      WarnOfMaterial(context, fmt::format("the index {} is not supported: 1.5 is used", base.ior));
      base.ior = 1.5f;
    }
  }
  base.normal_texture = AddGltfTexture(context, TextureInfo(from.normalTexture), Encoding::kLinear,
                                       TextureUse::kNormals);
  base.normal_scale = float(from.normalTexture.scale);
  return base;
}

// Sets opacity from the alpha of a factor and a texture.
void SetOpacity(GltfTextures& context, const tinygltf::Material& from, Material& material) {
  const bool masked = from.alphaMode == "MASK";
  if (!masked && from.alphaMode != "BLEND") return;
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  double alpha = pbr.baseColorFactor.size() > 3 ? pbr.baseColorFactor[3] : 1;
  GltfTextureInfo info = TextureInfo(pbr.baseColorTexture);
  if (const auto* const extension = GltfExtension(from, kSpecularGlossiness)) {
    alpha = SpecularGlossinessAlpha(*extension);
    info = TextureInfo(*extension, "diffuseTexture");
  }
  material.opacity = GltfFraction(context, "the alpha of the base colour", alpha);
  if (masked) {
    // NaN becomes 0. Values above 1 hide everything, which is valid.
    material.opacity_cutoff = float(from.alphaCutoff > 0 ? from.alphaCutoff : 0);
  }
  material.opacity_texture = AddGltfTexture(context, info, Encoding::kAlpha, TextureUse::kOpacity);
  if (material.opacity_texture) {
    const Texture& texture = context.scene.textures[*material.opacity_texture];
    if (IsWhite(context.scene.images[texture.image])) {
      material.opacity_texture.reset();
      context.scene.textures.pop_back();
    }
  }
  // Colours of vertices can only lower the alpha. The cutoff stays where they might.
  if (masked && !material.opacity_texture && material.opacity < *material.opacity_cutoff) {
    material.opacity = 0;
    material.opacity_cutoff.reset();
  }
}

void SetEmission(GltfTextures& context, const tinygltf::Material& from, Material& material) {
  double strength = 1;
  if (const auto* const extension = GltfExtension(from, "KHR_materials_emissive_strength")) {
    strength = GltfNumber(*extension, "emissiveStrength", 1);
  }
  glm::dvec3 emission(0);
  for (std::size_t c = 0; c < 3 && c < from.emissiveFactor.size(); ++c) {
    emission[int(c)] = from.emissiveFactor[c] * strength;
    if (!(emission[int(c)] >= 0 && emission[int(c)] <= 1e18)) {
      throw InputError(
          InputPosition::File(context.path),
          fmt::format("material '{}' has an emission of {}", from.name, emission[int(c)]));
    }
  }
  if (emission == glm::dvec3(0)) return;
  material.emission = glm::vec3(emission);
  material.emits_on_both_sides = from.doubleSided;
  material.emission_texture = AddGltfTexture(context, TextureInfo(from.emissiveTexture),
                                             Encoding::kSrgb, TextureUse::kColor);
}

bool IsUnlit(const tinygltf::Material& material) {
  return GltfExtension(material, khr::kUnlit) != nullptr;
}

// Returns the material that looks the same in any light: black, and of the radiance of its base
// colour. Radiance has no colours of vertices; a mesh that has some is lit as Lambert.
Material Unlit(GltfTextures& context, const tinygltf::Material& from, const Material& base,
               bool tinted) {
  Material material = {.name = base.name, .bsdf = BsdfKind::kLambert};
  if (tinted) {
    WarnOfMaterial(context, "unlit with colours of vertices: rendered as Lambert");
    material.reflectance = base.reflectance, material.color_texture = base.color_texture;
    return material;
  }
  material.reflectance = glm::vec3(0);
  material.emission = base.reflectance, material.emission_texture = base.color_texture;
  material.emits_on_both_sides = from.doubleSided;
  return material;
}

// Returns whether a mesh with colours of vertices has another material than one without.
bool TintMatters(const tinygltf::Material& from) {
  return IsUnlit(from) || GltfExtension(from, khr::kDiffuseTransmission) != nullptr;
}

Material MakeMaterial(GltfTextures& context, const tinygltf::Material& from, bool tinted) {
  WarnOfWhatIsLeftOut(context, from);
  if (tinted && GltfExtension(from, khr::kDiffuseTransmission) != nullptr) {
    WarnOfMaterial(context, "colours of vertices tint what is transmitted diffusely, too");
  }
  Material base = BaseOf(context, from);
  Material material;
  if (IsUnlit(from)) {
    material = Unlit(context, from, base, tinted);
  } else if (GltfTransmits(from)) {
    material = TransmittingGltf(context, from, std::move(base));
  } else {
    material = LayeredGltf(context, from, std::move(base));
  }
  material.name = from.name;
  // What transmits is seen from inside, too.
  material.one_sided = !from.doubleSided && !GltfTransmits(from);
  SetOpacity(context, from, material);
  if (!IsUnlit(from)) SetEmission(context, from, material);
  return material;
}

bool IsGrained(const tinygltf::Material& from) {
  const auto* const anisotropy = GltfExtension(from, khr::kAnisotropy);
  return anisotropy != nullptr && GltfNumber(*anisotropy, "anisotropyStrength", 0) > 0;
}

// Returns the coordinates that have to be the first ones of a mesh, because a grain lies along
// them: those of the normal map, or else of its own texture.
std::vector<int> UvSetsOfGrain(const tinygltf::Material& from) {
  if (!IsGrained(from)) return {};
  if (from.normalTexture.index >= 0) return {TextureInfo(from.normalTexture).uv_set};
  const GltfTextureInfo grain =
      TextureInfo(*GltfExtension(from, khr::kAnisotropy), "anisotropyTexture");
  return grain.index < 0 ? std::vector<int>{} : std::vector{grain.uv_set};
}

}  // namespace

std::vector<std::string> GltfVariants(const tinygltf::Model& model) {
  std::vector<std::string> names;
  const auto found = model.extensions.find(khr::kVariants);
  if (found == model.extensions.end() || !found->second.Has("variants")) return names;
  const tinygltf::Value& variants = found->second.Get("variants");
  for (std::size_t i = 0; i < variants.ArrayLen(); ++i) {
    const tinygltf::Value& variant = variants.Get(int(i));
    const bool named = variant.Has("name") && variant.Get("name").IsString();
    names.push_back(named ? variant.Get("name").Get<std::string>() : fmt::format("#{}", i));
  }
  return names;
}

GltfMaterials::GltfMaterials(const tinygltf::Model& model, const std::string& path, Scene& scene,
                             Warnings& warnings)
    : textures_{model, path, scene, warnings} {}

void GltfMaterials::DecodeImagesOf(std::span<const tinygltf::Primitive* const> primitives) {
  // The materials say which images they want, and how encoded, when they are made.
  Scene unused;
  Warnings unheard = MakeWarnings({});
  GltfMaterials trial(textures_.model, textures_.path, unused, unheard);
  std::set<GltfImageKey> wanted;
  trial.textures_.wanted = &wanted;
  trial.variant_ = variant_;
  for (const tinygltf::Primitive* const primitive : primitives) {
    try {
      trial.Of(*primitive);
    } catch (const InputError&) {
      continue;  // the material itself is refused when it is made
    }
  }
  DecodeAhead(wanted, textures_);
}

int GltfMaterials::IndexOf(const tinygltf::Primitive& primitive) const {
  const auto found = primitive.extensions.find(khr::kVariants);
  if (variant_ < 0 || found == primitive.extensions.end() || !found->second.Has("mappings")) {
    return primitive.material;
  }
  const tinygltf::Value& mappings = found->second.Get("mappings");
  for (std::size_t i = 0; i < mappings.ArrayLen(); ++i) {
    const tinygltf::Value& mapping = mappings.Get(int(i));
    if (!mapping.Has("variants")) continue;
    const tinygltf::Value& variants = mapping.Get("variants");
    for (std::size_t v = 0; v < variants.ArrayLen(); ++v) {
      if (variants.Get(int(v)).GetNumberAsInt() == variant_) {
        return GltfIndex(mapping, "material", -1);
      }
    }
  }
  return primitive.material;
}

const GltfMaterial& GltfMaterials::Of(const tinygltf::Primitive& primitive) {
  const int index = IndexOf(primitive);
  const std::vector<tinygltf::Material>& materials = textures_.model.materials;
  if (index >= int(materials.size())) {
    throw InputError(InputPosition::File(textures_.path),
                     fmt::format("there is no material {}", index));
  }
  const bool tinted = index >= 0 && TintMatters(materials[std::size_t(index)]) &&
                      primitive.attributes.contains("COLOR_0");
  const auto [known, is_new] = used_.try_emplace({std::max(index, -1), tinted});
  if (!is_new) return known->second;
  // Primitives without a material get all defaults of the schema.
  Material material = {.name = "default",
                       .bsdf = BsdfKind::kMetallicRoughness,
                       .reflectance = glm::vec3(1),
                       .alpha = 1,
                       .metallic = 1,
                       .one_sided = true};
  GltfMaterial& used = known->second;
  if (index >= 0) {
    const tinygltf::Material& from = materials[std::size_t(index)];
    textures_.material = from.name.empty() ? fmt::format("#{}", index) : from.name;
    textures_.uv_sets = UvSetsOfGrain(from);
    material = MakeMaterial(textures_, from, tinted);
    used.grained = IsGrained(from);
    used.uses_tangents = from.normalTexture.index >= 0 || used.grained;
    used.uv_sets = textures_.uv_sets;
    used.opaque = from.alphaMode == "OPAQUE";
  }
  used.row = std::uint32_t(textures_.scene.materials.size());
  textures_.scene.materials.push_back(std::move(material));
  return used;
}

}  // namespace skywave
