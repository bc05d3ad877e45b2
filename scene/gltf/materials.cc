#include "scene/gltf/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/error.h"
#include "scene/gltf/buffers.h"
#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

struct Context {
  const tinygltf::Model& model;
  const std::string& path;
  Scene& scene;
  Warnings& warnings;
  std::map<std::pair<int, Encoding>, std::uint32_t> images = {};
  std::string material = {};  // the one that is being made
};

void Warn(Context& context, const std::string& text) {
  AddWarning(context.warnings, InputPosition::File(context.path), text);
}

// The same with the name of the material.
void WarnOfMaterial(Context& context, const std::string& text) {
  Warn(context, fmt::format("material '{}': {}", context.material, text));
}

// Returns a number of an extension, or `otherwise` if it has none.
double Number(const tinygltf::Value& object, const char* name, double otherwise) {
  if (!object.IsObject() || !object.Has(name) || !object.Get(name).IsNumber()) return otherwise;
  return object.Get(name).GetNumberAsDouble();
}
glm::dvec2 Pair(const tinygltf::Value& object, const char* name, const glm::dvec2& otherwise) {
  if (!object.IsObject() || !object.Has(name) || !object.Get(name).IsArray() ||
      object.Get(name).ArrayLen() != 2) {
    return otherwise;
  }
  const tinygltf::Value& pair = object.Get(name);
  if (!pair.Get(0).IsNumber() || !pair.Get(1).IsNumber()) return otherwise;
  return {pair.Get(0).GetNumberAsDouble(), pair.Get(1).GetNumberAsDouble()};
}

std::uint32_t AddImage(Context& context, int index, Encoding encoding) {
  if (index < 0 || std::size_t(index) >= context.model.images.size()) {
    throw InputError(InputPosition::File(context.path), fmt::format("there is no image {}", index));
  }
  const auto key = std::pair(index, encoding);
  if (const auto found = context.images.find(key); found != context.images.end()) {
    return found->second;
  }
  const tinygltf::Image& image = context.model.images[std::size_t(index)];
  const std::string name = fmt::format("{}, image {}", context.path, index);
  std::string_view bytes(reinterpret_cast<const char*>(image.image.data()), image.image.size());
  if (image.bufferView >= 0) bytes = GltfBytes(context.model, image.bufferView, context.path);
  if (bytes.empty()) throw InputError(InputPosition::File(name), "is missing or empty");
  if (!IsPngOrJpeg(bytes)) {
    throw InputError(InputPosition::File(name), "is neither PNG nor JPEG");
  }
  const std::uint32_t added =
      AddTextureImage(context.scene, DecodeTexture(name, bytes, encoding, kTextureLimits));
  context.images.emplace(key, added);
  return added;
}

TextureWrap Wrap(int gl) {
  if (gl == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureWrap::kClamp;
  if (gl == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return TextureWrap::kMirror;
  return TextureWrap::kRepeat;
}

// Returns the matrix of the extension: scale, counter-clockwise rotation in the picture, then
// translation.
glm::mat3x2 Transform(const tinygltf::Value& extension) {
  const glm::dvec2 scale = Pair(extension, "scale", {1, 1});
  const glm::dvec2 offset = Pair(extension, "offset", {0, 0});
  const double angle = Number(extension, "rotation", 0);
  const double c = std::cos(angle), s = std::sin(angle);
  return glm::mat3x2(
      glm::dmat3x2(c * scale.x, -s * scale.x, s * scale.y, c * scale.y, offset.x, offset.y));
}

// Returns nothing if the material has no such texture. `set` receives the uv set that the texture
// uses.
template <class Info>
std::optional<std::uint32_t> AddTexture(Context& context, const Info& info, Encoding encoding,
                                        TextureUse use, int& set) {
  if (info.index < 0) return std::nullopt;
  if (std::size_t(info.index) >= context.model.textures.size()) {
    throw InputError(InputPosition::File(context.path),
                     fmt::format("there is no texture {}", info.index));
  }
  const tinygltf::Texture& from = context.model.textures[std::size_t(info.index)];
  if (from.source < 0) {
    Warn(context, fmt::format("texture {} has no image that is known: left out", info.index));
    return std::nullopt;
  }
  Texture texture;
  texture.use = use;
  set = info.texCoord;
  std::string problem;
  try {
    texture.image = AddImage(context, from.source, encoding);
  } catch (const InputError& error) {
    problem = error.what();
  }
  if (!problem.empty()) {
    // What was taken for a name may be the data of a picture.
    std::string uri;
    if (std::size_t(from.source) < context.model.images.size()) {
      uri = context.model.images[std::size_t(from.source)].uri.substr(0, 80);
    }
    WarnOfMaterial(context, fmt::format("texture {} is left out: {}{}", info.index, problem,
                                        uri.empty() ? "" : fmt::format(" (\"{}\")", uri)));
    return std::nullopt;
  }
  if (from.sampler >= 0 && std::size_t(from.sampler) < context.model.samplers.size()) {
    const tinygltf::Sampler& sampler = context.model.samplers[std::size_t(from.sampler)];
    texture.wrap_u = Wrap(sampler.wrapS), texture.wrap_v = Wrap(sampler.wrapT);
    if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) {
      WarnOfMaterial(context,
                     "samplers of the filter NEAREST are not supported: textures are "
                     "interpolated");
    }
  }
  if (const auto found = info.extensions.find("KHR_texture_transform");
      found != info.extensions.end()) {
    texture.transform = Transform(found->second);
    set = int(Number(found->second, "texCoord", set));
  }
  context.scene.textures.push_back(texture);
  return std::uint32_t(context.scene.textures.size() - 1);
}

float Fraction(Context& context, const char* name, double value) {
  if (value >= 0 && value <= 1) return float(value);
  Warn(context, fmt::format("{} {} is clamped to [0, 1]", name, value));
  return value > 0 ? 1.0f : 0.0f;  // NaN becomes 0
}

constexpr std::string_view kExtensions[] = {
    "KHR_materials_ior",      "KHR_materials_transmission",     "KHR_materials_unlit",
    "KHR_materials_volume",   "KHR_materials_clearcoat",        "KHR_materials_sheen",
    "KHR_materials_specular", "KHR_materials_emissive_strength"};

constexpr const char* kCoatNormals = "clearcoatNormalTexture";

// Returns the object of an extension, or null if the material lacks it.
const tinygltf::Value* Extension(const tinygltf::Material& from, const char* name) {
  const auto found = from.extensions.find(name);
  return found == from.extensions.end() ? nullptr : &found->second;
}

glm::vec3 Color(const tinygltf::Value& object, const char* name, const glm::vec3& otherwise) {
  if (!object.IsObject() || !object.Has(name) || !object.Get(name).IsArray() ||
      object.Get(name).ArrayLen() != 3) {
    return otherwise;
  }
  glm::vec3 color;
  for (int c = 0; c < 3; ++c) {
    const tinygltf::Value& channel = object.Get(name).Get(c);
    color[c] = channel.IsNumber() ? float(channel.GetNumberAsDouble()) : otherwise[c];
  }
  return color;
}

// Returns the index whose reflectance at normal incidence is that of `ior` times `factor`.
float ScaledIndex(float ior, double factor) {
  const double amplitude = std::sqrt(factor) * (ior - 1) / (ior + 1);
  return float((1 + amplitude) / (1 - amplitude));
}

// A lower index stands in for a weaker specular lobe.
void SetSpecular(Context& context, const tinygltf::Material& from, Material& material) {
  const tinygltf::Value* const found = Extension(from, "KHR_materials_specular");
  if (found == nullptr) return;
  const double factor = Fraction(context, "specularFactor", Number(*found, "specularFactor", 1));
  const glm::vec3 color = Color(*found, "specularColorFactor", glm::vec3(1));
  if (color.x != color.y || color.y != color.z) {
    Warn(context, "specularColorFactor: its mean is used");
  }
  const double mean = std::clamp(double(color.x + color.y + color.z) / 3, 0.0, 1.0);
  material.ior = ScaledIndex(material.ior, factor * mean);
}

void AddLayers(Context& context, const tinygltf::Material& from, Material& material) {
  const tinygltf::Value* const coat = Extension(from, "KHR_materials_clearcoat");
  const tinygltf::Value* const sheen = Extension(from, "KHR_materials_sheen");
  if (coat != nullptr) {
    material.coat = Fraction(context, "clearcoatFactor", Number(*coat, "clearcoatFactor", 0));
    const float roughness =
        Fraction(context, "clearcoatRoughnessFactor", Number(*coat, "clearcoatRoughnessFactor", 0));
    material.coat_alpha = roughness * roughness;
  } else {
    material.coat = 0;
  }
  if (sheen != nullptr) {
    const glm::vec3 color = Color(*sheen, "sheenColorFactor", glm::vec3(0));
    for (int c = 0; c < 3; ++c) {
      material.sheen[c] = Fraction(context, "sheenColorFactor", color[c]);
    }
    const float roughness =
        Fraction(context, "sheenRoughnessFactor", Number(*sheen, "sheenRoughnessFactor", 0));
    material.sheen_alpha = roughness * roughness;
  }
  if (material.coat > 0 || material.sheen != glm::vec3(0)) {
    material.bsdf = BsdfKind::kCoatedMetallicRoughness;
  }
}

// The file may give the coat different normals from the base; also when it gives normals to the
// base only.
void WarnOfCoatNormals(Context& context, const tinygltf::Material& from) {
  const tinygltf::Value& coat = *Extension(from, "KHR_materials_clearcoat");
  const int normals =
      coat.Has(kCoatNormals) ? int(Number(coat.Get(kCoatNormals), "index", -1)) : -1;
  if (normals == from.normalTexture.index) return;
  Warn(context, "KHR_materials_clearcoat: the coat is rendered with the normals of the base");
}

// After `attenuationDistance` in a volume, white light has become `attenuationColor`.
glm::vec3 Absorption(Context& context, const tinygltf::Value& volume) {
  const double distance = Number(volume, "attenuationDistance", 0);  // 0 stands for infinity
  const glm::vec3 color = Color(volume, "attenuationColor", glm::vec3(1));
  glm::vec3 absorption(0);
  for (int c = 0; distance > 0 && c < 3; ++c) {
    const double left = std::max(Fraction(context, "attenuationColor", color[c]), 1e-6f);
    absorption[c] = float(std::min(-std::log(left) / distance, 1e18));
  }
  return absorption;
}

// Returns whether the material is rendered as glass. The rest of the model is a mixture of glass
// and of an opaque or metallic base, of which the larger part is rendered.
bool IsGlass(Context& context, const tinygltf::Material& from, float metallic) {
  const tinygltf::Value* const found = Extension(from, "KHR_materials_transmission");
  if (found == nullptr) return false;
  const double factor =
      Fraction(context, "transmissionFactor", Number(*found, "transmissionFactor", 0));
  // The default of the metallic factor is 1, and a texture has the values as a rule.
  const bool textured = from.pbrMetallicRoughness.metallicRoughnessTexture.index >= 0;
  const double share = textured ? factor : factor * (1 - double(metallic));
  const bool glass = share >= 0.5;
  if (share > 0 && share < 1) {
    WarnOfMaterial(context, fmt::format("partial transmission of {:.3g} is not supported: it is "
                                        "rendered {}",
                                        share, glass ? "as glass" : "without transmission"));
  }
  return glass;
}

void WarnOfGlass(Context& context, const tinygltf::Material& from, const Material& opaque) {
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  if (pbr.baseColorTexture.index >= 0) {
    WarnOfMaterial(context,
                   "the baseColorTexture of transmission is not supported: its factor is "
                   "used everywhere");
  }
  if (pbr.metallicRoughnessTexture.index >= 0) {
    WarnOfMaterial(context,
                   "the metallicRoughnessTexture of transmission is not supported: its "
                   "roughness factor is used everywhere, and no metal");
  }
  if (opaque.reflectance != glm::vec3(1)) {
    WarnOfMaterial(context, "the colour of transmission is rendered on reflections too");
  }
}

// Without a volume, the extension describes a thin pane.
Material Transmission(Context& context, const tinygltf::Material& from, const Material& opaque) {
  const tinygltf::Value* const volume = Extension(from, "KHR_materials_volume");
  const bool solid = volume != nullptr && Number(*volume, "thicknessFactor", 0) > 0;
  Material glass = {.name = opaque.name,
                    .bsdf = solid ? BsdfKind::kDielectric : BsdfKind::kThinDielectric,
                    .reflectance = opaque.reflectance,
                    .alpha = opaque.alpha,
                    .ior = opaque.ior};
  if (solid && glass.alpha >= 1e-3f && glass.ior > 1.001f) {
    glass.bsdf = BsdfKind::kRoughDielectric;
  } else if (glass.alpha > 0.01f) {
    Warn(context, "rough transmission without a volume is rendered smooth");
  }
  if (solid) glass.absorption = Absorption(context, *volume);
  return glass;
}

void WarnOfWhatIsLeftOut(Context& context, const tinygltf::Material& from) {
  for (const auto& [name, value] : from.extensions) {
    if (std::find(std::begin(kExtensions), std::end(kExtensions), name) != std::end(kExtensions)) {
      for (const std::string& key : value.IsObject() ? value.Keys() : std::vector<std::string>()) {
        if (!key.ends_with("Texture") || key == kCoatNormals) continue;
        Warn(context,
             fmt::format("{} of {} is not supported: its factor is used everywhere", key, name));
      }
      continue;
    }
    Warn(context, fmt::format("the extension {} is not supported: left out", name));
  }
}

// Sets opacity from the alpha of factor and base colour texture. `set` receives the uv set of the
// texture.
void SetOpacity(Context& context, const tinygltf::Material& from, int& set, Material& material) {
  const bool masked = from.alphaMode == "MASK";
  if (!masked && from.alphaMode != "BLEND") return;
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  const double factor = pbr.baseColorFactor.size() > 3 ? pbr.baseColorFactor[3] : 1;
  material.opacity = Fraction(context, "alpha of baseColorFactor", factor);
  if (masked) {
    // NaN becomes 0. Values above 1 hide everything, which is valid.
    material.opacity_cutoff = float(from.alphaCutoff > 0 ? from.alphaCutoff : 0);
  }
  material.opacity_texture =
      AddTexture(context, pbr.baseColorTexture, Encoding::kAlpha, TextureUse::kOpacity, set);
  if (material.opacity_texture) {
    const Texture& texture = context.scene.textures[*material.opacity_texture];
    if (IsWhite(context.scene.images[texture.image])) {
      material.opacity_texture.reset();
      context.scene.textures.pop_back();
    }
  }
  if (masked && !material.opacity_texture) {
    material.opacity = material.opacity >= *material.opacity_cutoff ? 1.0f : 0.0f;
    material.opacity_cutoff.reset();
  }
}

// Sets the emission. `uv_set` is that of the material's other textures, or negative if it has none.
void SetEmission(Context& context, const tinygltf::Material& from, int& uv_set,
                 Material& material) {
  double strength = 1;
  if (const auto found = from.extensions.find("KHR_materials_emissive_strength");
      found != from.extensions.end()) {
    strength = Number(found->second, "emissiveStrength", 1);
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
  int set = uv_set;
  material.emission_texture =
      AddTexture(context, from.emissiveTexture, Encoding::kSrgb, TextureUse::kColor, set);
  if (!material.emission_texture) return;
  if (uv_set >= 0 && set != uv_set) {
    Warn(context,
         "two sets of texture coordinates in a material are not supported: the first one is used "
         "for the emission too");
  } else {
    uv_set = set;
  }
}

Material MakeMaterial(Context& context, const tinygltf::Material& from, int& uv_set) {
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  Material material;
  material.name = from.name;
  context.material = from.name;
  material.bsdf = BsdfKind::kMetallicRoughness;
  for (std::size_t c = 0; c < 3; ++c) {
    const double factor = c < pbr.baseColorFactor.size() ? pbr.baseColorFactor[c] : 1;
    material.reflectance[int(c)] = Fraction(context, "baseColorFactor", factor);
  }
  const float roughness = Fraction(context, "roughnessFactor", pbr.roughnessFactor);
  material.alpha = roughness * roughness;
  material.metallic = Fraction(context, "metallicFactor", pbr.metallicFactor);
  WarnOfWhatIsLeftOut(context, from);
  if (const auto ior = from.extensions.find("KHR_materials_ior"); ior != from.extensions.end()) {
    material.ior = float(Number(ior->second, "ior", 1.5));
    if (!(material.ior >= 1 && material.ior <= 100)) {
      // In old files, 0 stands for a coat that reflects everything.
      Warn(context, fmt::format("the index {} is not supported: 1.5 is used", material.ior));
      material.ior = 1.5f;
    }
  }
  uv_set = -1;
  int roughness_set = -1, normal_set = -1;
  if (IsGlass(context, from, material.metallic)) {
    WarnOfGlass(context, from, material);
    material = Transmission(context, from, material);
  } else {
    SetSpecular(context, from, material);
    AddLayers(context, from, material);
    material.color_texture =
        AddTexture(context, pbr.baseColorTexture, Encoding::kSrgb, TextureUse::kColor, uv_set);
    material.roughness_texture = AddTexture(context, pbr.metallicRoughnessTexture,
                                            Encoding::kLinear, TextureUse::kColor, roughness_set);
  }
  material.normal_texture =
      AddTexture(context, from.normalTexture, Encoding::kLinear, TextureUse::kNormals, normal_set);
  material.normal_scale = float(from.normalTexture.scale);
  if (material.bsdf == BsdfKind::kCoatedMetallicRoughness && material.coat > 0) {
    WarnOfCoatNormals(context, from);
  }
  SetOpacity(context, from, uv_set, material);
  if (uv_set < 0) uv_set = std::max(roughness_set, normal_set);
  if ((material.roughness_texture && roughness_set != uv_set) ||
      (material.normal_texture && normal_set != uv_set)) {
    Warn(context,
         "two sets of texture coordinates in a material are not supported: the set of "
         "the base colour is used");
  }
  if (from.extensions.contains("KHR_materials_unlit")) {
    Warn(context, "unlit materials are rendered as Lambert");
    material.bsdf = BsdfKind::kLambert;
    material.roughness_texture.reset();
    material.normal_texture.reset();
  }
  return material;
}

}  // namespace

GltfMaterials AddGltfMaterials(const tinygltf::Model& model, const std::string& path, Scene& scene,
                               Warnings& warnings) {
  Context context{model, path, scene, warnings};
  GltfMaterials materials;
  for (const tinygltf::Material& from : model.materials) {
    int set = -1;
    Material material = MakeMaterial(context, from, set);
    SetEmission(context, from, set, material);
    scene.materials.push_back(std::move(material));
    materials.uv_set.push_back(std::max(set, 0));
    materials.uses_tangents.push_back(scene.materials.back().normal_texture.has_value());
  }
  // Primitives without a material get all defaults of the schema.
  scene.materials.push_back({.name = "default",
                             .bsdf = BsdfKind::kMetallicRoughness,
                             .reflectance = glm::vec3(1),
                             .alpha = 1,
                             .metallic = 1});
  materials.uv_set.push_back(0);
  materials.uses_tangents.push_back(false);
  return materials;
}

}  // namespace skywave
