#include "scene/gltf_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/error.h"
#include "scene/gltf_buffers.h"
#include "scene/texture_files.h"

namespace skywave {
namespace {

struct Context {
  const tinygltf::Model& model;
  const std::string& path;
  Scene& scene;
  Warnings& warnings;
  std::map<std::pair<int, Encoding>, std::uint32_t> images = {};
};

void Warn(Context& context, const std::string& text) {
  AddWarning(context.warnings, InputPosition::File(context.path), text);
}

// A number of an extension, or what stands for it.
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

// The matrix of the extension: scaled, turned counter-clockwise in the picture, moved.
glm::mat3x2 Transform(const tinygltf::Value& extension) {
  const glm::dvec2 scale = Pair(extension, "scale", {1, 1});
  const glm::dvec2 offset = Pair(extension, "offset", {0, 0});
  const double angle = Number(extension, "rotation", 0);
  const double c = std::cos(angle), s = std::sin(angle);
  return glm::mat3x2(
      glm::dmat3x2(c * scale.x, -s * scale.x, s * scale.y, c * scale.y, offset.x, offset.y));
}

// Nothing where the material has no such texture. `set` becomes the uv set that it uses.
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
  texture.image = AddImage(context, from.source, encoding);
  if (from.sampler >= 0 && std::size_t(from.sampler) < context.model.samplers.size()) {
    const tinygltf::Sampler& sampler = context.model.samplers[std::size_t(from.sampler)];
    texture.wrap_u = Wrap(sampler.wrapS), texture.wrap_v = Wrap(sampler.wrapT);
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
  return value > 0 ? 1.0f : 0.0f;  // NaN is 0
}

void WarnOfWhatIsLeftOut(Context& context, const tinygltf::Material& from) {
  const auto& emission = from.emissiveFactor;
  if (std::any_of(emission.begin(), emission.end(), [](double e) { return e > 0; })) {
    Warn(context, "emission is not supported: left out");
  }
  for (const auto& [name, value] : from.extensions) {
    if (name == "KHR_materials_ior" || name == "KHR_materials_transmission" ||
        name == "KHR_materials_unlit") {
      continue;
    }
    Warn(context, fmt::format("the extension {} is not supported: left out", name));
  }
}

// The alpha of factor and base colour texture. `set` becomes the uv set of the texture.
void SetOpacity(Context& context, const tinygltf::Material& from, int& set, Material& material) {
  const bool masked = from.alphaMode == "MASK";
  if (!masked && from.alphaMode != "BLEND") return;
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  const double factor = pbr.baseColorFactor.size() > 3 ? pbr.baseColorFactor[3] : 1;
  material.opacity = Fraction(context, "alpha of baseColorFactor", factor);
  if (masked) {
    // NaN is 0. More than 1 hides everything, which is valid.
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

Material MakeMaterial(Context& context, const tinygltf::Material& from, int& uv_set) {
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  Material material;
  material.name = from.name;
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
      // 0 stands for a coat that reflects everything in old files.
      Warn(context, fmt::format("the index {} is not supported: 1.5 is used", material.ior));
      material.ior = 1.5f;
    }
  }
  if (const auto found = from.extensions.find("KHR_materials_transmission");
      found != from.extensions.end() && Number(found->second, "transmissionFactor", 0) >= 0.5) {
    if (roughness > 0.1f || material.reflectance != glm::vec3(1)) {
      Warn(context, "transmission is rendered as clear, smooth glass");
    }
    return {.name = from.name,
            .bsdf = BsdfKind::kDielectric,
            .reflectance = glm::vec3(1),
            .ior = material.ior};
  }
  int roughness_set = -1;
  int normal_set = -1;
  material.color_texture =
      AddTexture(context, pbr.baseColorTexture, Encoding::kSrgb, TextureUse::kColor, uv_set);
  material.roughness_texture = AddTexture(context, pbr.metallicRoughnessTexture, Encoding::kLinear,
                                          TextureUse::kColor, roughness_set);
  material.normal_texture =
      AddTexture(context, from.normalTexture, Encoding::kLinear, TextureUse::kNormals, normal_set);
  material.normal_scale = float(from.normalTexture.scale);
  SetOpacity(context, from, uv_set, material);
  if (!material.color_texture) uv_set = std::max({roughness_set, normal_set, 0});
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
    int set = 0;
    scene.materials.push_back(MakeMaterial(context, from, set));
    materials.uv_set.push_back(set);
    materials.uses_tangents.push_back(scene.materials.back().normal_texture.has_value());
  }
  // Of primitives without a material: all defaults of the schema.
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
