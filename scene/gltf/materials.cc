#include "scene/gltf/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/error.h"
#include "scene/gltf/specular_glossiness.h"
#include "scene/gltf/textures.h"
#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

float Fraction(GltfTextures& context, const char* name, double value) {
  if (value >= 0 && value <= 1) return float(value);
  WarnOfMaterial(context, fmt::format("{} {} is clamped to [0, 1]", name, value));
  return value > 0 ? 1.0f : 0.0f;  // NaN becomes 0
}
// Returns the number of an extension that should be a fraction.
float FractionOf(GltfTextures& context, const tinygltf::Value& extension, const char* name,
                 double otherwise) {
  return Fraction(context, name, GltfNumber(extension, name, otherwise));
}

constexpr const char* kAnisotropy = "KHR_materials_anisotropy";
constexpr const char* kCoat = "KHR_materials_clearcoat";
constexpr const char* kCoatNormals = "clearcoatNormalTexture";
constexpr const char* kDiffuseTransmission = "KHR_materials_diffuse_transmission";
constexpr const char* kFilm = "KHR_materials_iridescence";
constexpr const char* kSheen = "KHR_materials_sheen";
constexpr const char* kSpecular = "KHR_materials_specular";
constexpr const char* kTransmission = "KHR_materials_transmission";
constexpr const char* kUnlit = "KHR_materials_unlit";
constexpr const char* kVariants = "KHR_materials_variants";
constexpr const char* kVolume = "KHR_materials_volume";

// The extensions of materials, and the textures of them that are rendered.
struct KnownExtension {
  std::string_view name;
  std::vector<std::string_view> textures = {};
};
const KnownExtension kMaterialExtensions[] = {
    {"KHR_materials_ior"},
    {kTransmission, {"transmissionTexture"}},
    {kDiffuseTransmission, {"diffuseTransmissionTexture", "diffuseTransmissionColorTexture"}},
    {kUnlit},
    // A thickness is for renderers that do not trace rays through the volume.
    {kVolume, {"thicknessTexture"}},
    {kCoat, {"clearcoatTexture", "clearcoatRoughnessTexture", kCoatNormals}},
    {kSheen, {"sheenColorTexture", "sheenRoughnessTexture"}},
    {kSpecular, {"specularTexture", "specularColorTexture"}},
    {kAnisotropy, {"anisotropyTexture"}},
    {kFilm, {"iridescenceTexture", "iridescenceThicknessTexture"}},
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

// Returns the texture of an extension; kAlpha reads its alpha channel.
std::optional<std::uint32_t> TextureOf(GltfTextures& context, const tinygltf::Value& extension,
                                       const char* name, Encoding encoding) {
  return AddGltfTexture(context, TextureInfo(extension, name), encoding, TextureUse::kColor);
}

// Returns a factor that an extension allows to be any number from 0 on.
float Positive(GltfTextures& context, const tinygltf::Value& extension, const char* name,
               double otherwise) {
  const double value = GltfNumber(extension, name, otherwise);
  if (value >= 0 && value <= 1e6) return float(value);
  WarnOfMaterial(context,
                 fmt::format("{} {} is not supported: {} is used", name, value, otherwise));
  return float(otherwise);
}

void SetSpecular(GltfTextures& context, const tinygltf::Value& extension, Material& material) {
  material.specular = FractionOf(context, extension, "specularFactor", 1);
  material.specular_color =
      glm::clamp(GltfColor(extension, "specularColorFactor", glm::vec3(1)), 0.0f, 1e6f);
  material.specular_texture = TextureOf(context, extension, "specularTexture", Encoding::kAlpha);
  material.specular_color_texture =
      TextureOf(context, extension, "specularColorTexture", Encoding::kSrgb);
}

void SetAnisotropy(GltfTextures& context, const tinygltf::Value& extension, Material& material) {
  material.anisotropy = FractionOf(context, extension, "anisotropyStrength", 0);
  material.anisotropy_turn = float(GltfNumber(extension, "anisotropyRotation", 0));
  if (!(std::abs(material.anisotropy_turn) <= 1e6f)) {
    WarnOfMaterial(context, "anisotropyRotation is not supported: 0 is used");
    material.anisotropy_turn = 0;
  }
  if (!(material.anisotropy > 0)) return;
  material.anisotropy_texture =
      TextureOf(context, extension, "anisotropyTexture", Encoding::kLinear);
}

void SetFilm(GltfTextures& context, const tinygltf::Value& extension, Material& material) {
  const float factor = FractionOf(context, extension, "iridescenceFactor", 0);
  if (!(factor > 0)) return;
  const GltfShare share =
      AddGltfShare(context, TextureInfo(extension, "iridescenceTexture"), 0, factor);
  material.film = share.number, material.film_texture = share.texture;
  material.film_ior = Positive(context, extension, "iridescenceIor", 1.3);
  if (material.film_ior < 1) {
    WarnOfMaterial(context, fmt::format("iridescenceIor {} is below 1: 1 is used, which is no film",
                                        material.film_ior));
    material.film_ior = 1;
  }
  material.film_thin = Positive(context, extension, "iridescenceThicknessMinimum", 100);
  material.film_thick = Positive(context, extension, "iridescenceThicknessMaximum", 400);
  material.film_thickness_texture =
      TextureOf(context, extension, "iridescenceThicknessTexture", Encoding::kLinear);
}

// Sets what only layered metallic-roughness has, in the part of a material that reflects. Factors
// that change nothing leave the material as it is.
void SetLayers(GltfTextures& context, const tinygltf::Material& from, Material& material) {
  if (const auto* const extension = GltfExtension(from, kSpecular)) {
    SetSpecular(context, *extension, material);
  }
  if (const auto* const extension = GltfExtension(from, kAnisotropy)) {
    SetAnisotropy(context, *extension, material);
  }
  if (const auto* const extension = GltfExtension(from, kFilm)) {
    SetFilm(context, *extension, material);
  }
  const bool reflects_alike = material.specular == 1 && material.specular_color == glm::vec3(1) &&
                              !material.specular_texture && !material.specular_color_texture;
  if (!reflects_alike || material.anisotropy > 0 || material.film > 0) {
    material.bsdf = BsdfKind::kLayeredMetallicRoughness;
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
      base.reflectance[int(c)] = Fraction(context, "baseColorFactor", factor);
    }
    const float roughness = Fraction(context, "roughnessFactor", pbr.roughnessFactor);
    base.alpha = roughness * roughness;
    base.metallic = Fraction(context, "metallicFactor", pbr.metallicFactor);
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

// Returns the mixture of two materials, which it adds to the scene.
Material Mix(GltfTextures& context, Material first, Material second, const GltfShare& share) {
  std::vector<Material>& materials = context.scene.materials;
  materials.push_back(std::move(first)), materials.push_back(std::move(second));
  const auto row = std::uint32_t(materials.size());
  Material mixed = {.mixture = Mixture{row - 2, row - 1, share.number}};
  mixed.mixture_texture = share.texture;
  return mixed;
}
Material Named(const Material& base, const char* part) {
  Material named = base;
  named.name = fmt::format("{} ({})", base.name, part);
  return named;
}

// Returns a copy of a texture of roughness and metal that is metal everywhere.
std::uint32_t WithFullMetal(GltfTextures& context, std::uint32_t texture) {
  Scene& scene = context.scene;
  Texture copy = scene.textures[texture];
  Image image = scene.images[copy.image];
  for (std::size_t i = 2; i < image.rgb.size(); i += 3) image.rgb[i] = 1;
  copy.image = AddTextureImage(scene, std::move(image));
  scene.textures.push_back(copy);
  return std::uint32_t(scene.textures.size() - 1);
}

// The file may give the coat different normals from the base; also when it gives normals to the
// base only.
void WarnOfCoatNormals(GltfTextures& context, const tinygltf::Material& from) {
  const tinygltf::Value& coat = *GltfExtension(from, kCoat);
  if (TextureInfo(coat, kCoatNormals).index == from.normalTexture.index) return;
  WarnOfMaterial(context,
                 "KHR_materials_clearcoat: the coat is rendered with the normals of the base");
}

// Gives a material one more layer, of which `textures` says that it has textures that only layered
// metallic-roughness reads.
void AddLayer(bool textures, Material& material) {
  if (textures || material.bsdf == BsdfKind::kLayeredMetallicRoughness) {
    material.bsdf = BsdfKind::kLayeredMetallicRoughness;
  } else {
    material.bsdf = BsdfKind::kCoatedMetallicRoughness;
  }
}

// Returns the base with all its layers, under its sheen and its coat. A coat that is not everywhere
// is a mixture, as the extension's layer is linear in its strength.
Material Layered(GltfTextures& context, const tinygltf::Material& from, Material base) {
  SetLayers(context, from, base);
  if (const auto* const sheen = GltfExtension(from, kSheen)) {
    const glm::vec3 color = GltfColor(*sheen, "sheenColorFactor", glm::vec3(0));
    for (int c = 0; c < 3; ++c) base.sheen[c] = Fraction(context, "sheenColorFactor", color[c]);
    const float roughness = FractionOf(context, *sheen, "sheenRoughnessFactor", 0);
    base.sheen_alpha = roughness * roughness;
    if (base.sheen != glm::vec3(0)) {
      base.sheen_texture = TextureOf(context, *sheen, "sheenColorTexture", Encoding::kSrgb);
      base.sheen_alpha_texture =
          TextureOf(context, *sheen, "sheenRoughnessTexture", Encoding::kAlpha);
      AddLayer(base.sheen_texture || base.sheen_alpha_texture, base);
    }
  }
  base.coat = 0;
  const auto* const coat = GltfExtension(from, kCoat);
  const float strength = coat == nullptr ? 0 : FractionOf(context, *coat, "clearcoatFactor", 0);
  if (!(strength > 0)) return base;
  const GltfShare share =
      AddGltfShare(context, TextureInfo(*coat, "clearcoatTexture"), 0, strength);
  WarnOfCoatNormals(context, from);
  Material coated = base;
  coated.coat = share.number;
  const float roughness = FractionOf(context, *coat, "clearcoatRoughnessFactor", 0);
  coated.coat_alpha = roughness * roughness;
  if (roughness > 0) {
    coated.coat_alpha_texture =
        TextureOf(context, *coat, "clearcoatRoughnessTexture", Encoding::kLinear);
  }
  AddLayer(coated.coat_alpha_texture.has_value(), coated);
  if (!share.texture) return coated;
  return Mix(context, base, Named(coated, "coated"), share);
}

// After `attenuationDistance` in a volume, white light has become `attenuationColor`.
glm::vec3 Absorption(GltfTextures& context, const tinygltf::Value& volume) {
  const double distance = GltfNumber(volume, "attenuationDistance", 0);  // 0 stands for infinity
  const glm::vec3 color = GltfColor(volume, "attenuationColor", glm::vec3(1));
  glm::vec3 absorption(0);
  for (int c = 0; distance > 0 && c < 3; ++c) {
    const double left = std::max(Fraction(context, "attenuationColor", color[c]), 1e-6f);
    absorption[c] = float(std::min(-std::log(left) / distance, 1e18));
  }
  return absorption;
}

// Returns the glass that transmits in the base colour and reflects white. Without a volume, the
// extension describes a thin pane.
Material GlassOf(GltfTextures& context, const tinygltf::Material& from, const Material& base) {
  const tinygltf::Value* const volume = GltfExtension(from, kVolume);
  const bool solid = volume != nullptr && GltfNumber(*volume, "thicknessFactor", 0) > 0;
  Material glass = Named(base, "glass");
  glass.metallic = 0;
  glass.reflection = glm::vec3(1);
  const bool smooth = !(base.alpha >= 1e-3f) || base.ior <= 1.001f;
  if (solid) {
    glass.bsdf = smooth ? BsdfKind::kDielectric : BsdfKind::kRoughDielectric;
    glass.absorption = Absorption(context, *volume);
  } else {
    glass.bsdf = smooth ? BsdfKind::kThinDielectric : BsdfKind::kRoughThinDielectric;
  }
  if (smooth) glass.roughness_texture.reset();
  return glass;
}

// Returns what an extension mixes in: a factor times a channel of a texture, or nothing without the
// extension.
GltfShare ShareOf(GltfTextures& context, const tinygltf::Value* extension, const char* factor,
                  const char* texture, int channel) {
  if (extension == nullptr) return {0};
  return AddGltfShare(context, TextureInfo(*extension, texture), channel,
                      FractionOf(context, *extension, factor, 0));
}

// Returns the coat over a body that lets everything through, in the colour of the extension.
Material SheetOf(GltfTextures& context, const tinygltf::Material& from, const Material& base) {
  const tinygltf::Value& extension = *GltfExtension(from, kDiffuseTransmission);
  if (const auto* const volume = GltfExtension(from, kVolume);
      volume != nullptr && GltfNumber(*volume, "thicknessFactor", 0) > 0) {
    WarnOfMaterial(context, "KHR_materials_volume: what is transmitted diffusely is not absorbed");
  }
  Material sheet = Named(base, "sheet");
  sheet.bsdf = BsdfKind::kCoatedDiffuseTransmission;
  sheet.metallic = 0;
  const glm::vec3 color = GltfColor(extension, "diffuseTransmissionColorFactor", glm::vec3(1));
  for (int c = 0; c < 3; ++c) {
    sheet.reflectance[c] = Fraction(context, "diffuseTransmissionColorFactor", color[c]);
  }
  sheet.color_texture =
      TextureOf(context, extension, "diffuseTransmissionColorTexture", Encoding::kSrgb);
  return sheet;
}

// Returns what glTF calls the material, a mix of metal and dielectric by `metallic`. The dielectric
// is a mix of glass and a body by the transmission, and the body one of a sheet and an opaque one
// by the diffuse transmission.
Material Transmitting(GltfTextures& context, const tinygltf::Material& from, Material base) {
  const GltfShare glass = ShareOf(context, GltfExtension(from, kTransmission), "transmissionFactor",
                                  "transmissionTexture", 0);
  const GltfShare sheet = ShareOf(context, GltfExtension(from, kDiffuseTransmission),
                                  "diffuseTransmissionFactor", "diffuseTransmissionTexture", 3);
  GltfShare metal = {base.metallic};
  const bool textured = base.roughness_texture.has_value() && base.metallic > 0;
  if (textured) {
    metal = AddGltfShare(context, TextureInfo(from.pbrMetallicRoughness.metallicRoughnessTexture),
                         2, base.metallic);
  }
  const bool all_metal = !metal.texture && metal.number >= 1;
  if (!(glass.number > 0 || sheet.number > 0) || all_metal) {
    return Layered(context, from, std::move(base));
  }
  constexpr std::pair<const char*, const char*> kOpaqueOnly[] = {{kCoat, "the coat"},
                                                                 {kSheen, "the sheen"},
                                                                 {kSpecular, "its colour"},
                                                                 {kAnisotropy, "its grain"},
                                                                 {kFilm, "the film"}};
  for (const auto& [extension_name, what] : kOpaqueOnly) {
    if (GltfExtension(from, extension_name) == nullptr) continue;
    WarnOfMaterial(context,
                   fmt::format("{}: what transmits is rendered without {}", extension_name, what));
  }
  const auto partial = [](const GltfShare& share) { return share.texture || share.number < 1; };
  const auto body = [&] {
    Material opaque = Named(base, "opaque");
    opaque.metallic = 0;
    if (partial(sheet)) opaque = Layered(context, from, std::move(opaque));
    if (!(sheet.number > 0)) return opaque;
    Material whole = SheetOf(context, from, base);
    return partial(sheet) ? Mix(context, std::move(opaque), std::move(whole), sheet) : whole;
  };
  Material dielectric = partial(glass) ? body() : GlassOf(context, from, base);
  if (partial(glass) && glass.number > 0) {
    dielectric = Mix(context, std::move(dielectric), GlassOf(context, from, base), glass);
  }
  if (!metal.texture && !(metal.number > 0)) return dielectric;
  Material metallic = Named(base, "metal");
  metallic.metallic = 1;
  if (textured) metallic.roughness_texture = WithFullMetal(context, *base.roughness_texture);
  return Mix(context, std::move(dielectric), Layered(context, from, std::move(metallic)), metal);
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
  material.opacity = Fraction(context, "the alpha of the base colour", alpha);
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
  return GltfExtension(material, kUnlit) != nullptr;
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

bool Transmits(const tinygltf::Material& from) {
  return GltfExtension(from, kTransmission) != nullptr ||
         GltfExtension(from, kDiffuseTransmission) != nullptr;
}

// Returns whether a mesh with colours of vertices has another material than one without.
bool TintMatters(const tinygltf::Material& from) {
  return IsUnlit(from) || GltfExtension(from, kDiffuseTransmission) != nullptr;
}

Material MakeMaterial(GltfTextures& context, const tinygltf::Material& from, bool tinted) {
  WarnOfWhatIsLeftOut(context, from);
  if (tinted && GltfExtension(from, kDiffuseTransmission) != nullptr) {
    WarnOfMaterial(context, "colours of vertices tint what is transmitted diffusely, too");
  }
  Material base = BaseOf(context, from);
  Material material;
  if (IsUnlit(from)) {
    material = Unlit(context, from, base, tinted);
  } else if (Transmits(from)) {
    material = Transmitting(context, from, std::move(base));
  } else {
    material = Layered(context, from, std::move(base));
  }
  material.name = from.name;
  // What transmits is seen from inside, too.
  material.one_sided = !from.doubleSided && !Transmits(from);
  SetOpacity(context, from, material);
  if (!IsUnlit(from)) SetEmission(context, from, material);
  return material;
}

}  // namespace

std::vector<std::string> GltfVariants(const tinygltf::Model& model) {
  std::vector<std::string> names;
  const auto found = model.extensions.find(kVariants);
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

int GltfMaterials::IndexOf(const tinygltf::Primitive& primitive) const {
  const auto found = primitive.extensions.find(kVariants);
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
        return int(GltfNumber(mapping, "material", -1));
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
    textures_.uv_sets.clear();
    material = MakeMaterial(textures_, from, tinted);
    const auto* const anisotropy = GltfExtension(from, kAnisotropy);
    used.grained = anisotropy != nullptr && GltfNumber(*anisotropy, "anisotropyStrength", 0) > 0;
    used.uses_tangents = from.normalTexture.index >= 0 || used.grained;
    used.uv_sets = textures_.uv_sets;
    used.opaque = from.alphaMode == "OPAQUE";
  }
  used.row = std::uint32_t(textures_.scene.materials.size());
  textures_.scene.materials.push_back(std::move(material));
  return used;
}

}  // namespace skywave
