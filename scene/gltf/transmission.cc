#include "scene/gltf/transmission.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/gltf/extensions.h"
#include "scene/gltf/layers.h"
#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

// Returns a copy of a texture of roughness and metal that is metal everywhere.
std::uint32_t WithFullMetal(GltfTextures& context, std::uint32_t texture) {
  Scene& scene = context.scene;
  Texture copy = scene.textures[texture];
  Image image = scene.images[copy.image].Floats();
  for (std::size_t i = 2; i < image.rgb.size(); i += 3) image.rgb[i] = 1;
  copy.image = AddTextureImage(scene, std::move(image));
  scene.textures.push_back(copy);
  return std::uint32_t(scene.textures.size() - 1);
}

// After `attenuationDistance` in a volume, white light has become `attenuationColor`.
glm::vec3 Absorption(GltfTextures& context, const tinygltf::Value& volume) {
  const double distance = GltfNumber(volume, "attenuationDistance", 0);  // 0 stands for infinity
  const glm::vec3 color = GltfColor(volume, "attenuationColor", glm::vec3(1));
  glm::vec3 absorption(0);
  for (int c = 0; distance > 0 && c < 3; ++c) {
    const double left = std::max(GltfFraction(context, "attenuationColor", color[c]), 1e-6f);
    absorption[c] = float(std::min(-std::log(left) / distance, 1e18));
  }
  return absorption;
}

// Returns the glass that transmits in the base colour and reflects white, or what its layers
// make of that, under its coat. Without a volume, the extension describes a thin pane.
Material GlassOf(GltfTextures& context, const tinygltf::Material& from, const Material& base) {
  const tinygltf::Value* const volume = GltfExtension(from, khr::kVolume);
  const bool solid = volume != nullptr && GltfNumber(*volume, "thicknessFactor", 0) > 0;
  Material glass = NamedPart(base, "glass");
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
  SetGltfReflection(context, from, glass);
  return CoatedGltfGlass(context, from, std::move(glass));
}

// Returns what an extension mixes in: a factor times a channel of a texture, or nothing without the
// extension.
GltfShare ShareOf(GltfTextures& context, const tinygltf::Value* extension, const char* factor,
                  const char* texture, int channel) {
  if (extension == nullptr) return {0};
  return AddGltfShare(context, TextureInfo(*extension, texture), channel,
                      GltfFractionOf(context, *extension, factor, 0));
}

// Returns the coat over a body that lets everything through, in the colour of the extension.
Material SheetOf(GltfTextures& context, const tinygltf::Material& from, const Material& base) {
  const tinygltf::Value& extension = *GltfExtension(from, khr::kDiffuseTransmission);
  if (const auto* const volume = GltfExtension(from, khr::kVolume);
      volume != nullptr && GltfNumber(*volume, "thicknessFactor", 0) > 0) {
    WarnOfMaterial(context, "KHR_materials_volume: what is transmitted diffusely is not absorbed");
  }
  Material sheet = NamedPart(base, "sheet");
  sheet.bsdf = BsdfKind::kCoatedDiffuseTransmission;
  sheet.metallic = 0;
  const glm::vec3 color = GltfColor(extension, "diffuseTransmissionColorFactor", glm::vec3(1));
  for (int c = 0; c < 3; ++c) {
    sheet.reflectance[c] = GltfFraction(context, "diffuseTransmissionColorFactor", color[c]);
  }
  sheet.color_texture =
      GltfTextureOf(context, extension, "diffuseTransmissionColorTexture", Encoding::kSrgb);
  return sheet;
}

}  // namespace

bool GltfTransmits(const tinygltf::Material& from) {
  return GltfExtension(from, khr::kTransmission) != nullptr ||
         GltfExtension(from, khr::kDiffuseTransmission) != nullptr;
}

Material TransmittingGltf(GltfTextures& context, const tinygltf::Material& from, Material base) {
  const GltfShare glass = ShareOf(context, GltfExtension(from, khr::kTransmission),
                                  "transmissionFactor", "transmissionTexture", 0);
  const GltfShare sheet = ShareOf(context, GltfExtension(from, khr::kDiffuseTransmission),
                                  "diffuseTransmissionFactor", "diffuseTransmissionTexture", 3);
  GltfShare metal = {base.metallic};
  const bool textured = base.roughness_texture.has_value() && base.metallic > 0;
  if (textured) {
    metal = AddGltfShare(context, TextureInfo(from.pbrMetallicRoughness.metallicRoughnessTexture),
                         2, base.metallic);
  }
  const bool all_metal = !metal.texture && metal.number >= 1;
  if (!(glass.number > 0 || sheet.number > 0) || all_metal) {
    return LayeredGltf(context, from, std::move(base));
  }
  struct Layer {
    const char *extension, *what;
    bool over_glass;
  };
  constexpr Layer kLayers[] = {{khr::kClearcoat, "the coat", true},
                               {khr::kSheen, "the sheen", false},
                               {khr::kAnisotropy, "its grain", false},
                               {khr::kSpecular, "its colour", true},
                               {khr::kIridescence, "the film", true}};
  for (const Layer& layer : kLayers) {
    const bool is_lost = sheet.number > 0 || !layer.over_glass;
    if (!is_lost || GltfExtension(from, layer.extension) == nullptr) continue;
    WarnOfMaterial(context,
                   fmt::format("{}: what transmits{} is rendered without {}", layer.extension,
                               layer.over_glass ? " diffusely" : "", layer.what));
  }
  const auto partial = [](const GltfShare& share) { return share.texture || share.number < 1; };
  const auto body = [&] {
    Material opaque = NamedPart(base, "opaque");
    opaque.metallic = 0;
    if (partial(sheet)) opaque = LayeredGltf(context, from, std::move(opaque));
    if (!(sheet.number > 0)) return opaque;
    Material whole = SheetOf(context, from, base);
    return partial(sheet) ? GltfMixture(context, std::move(opaque), std::move(whole), sheet)
                          : whole;
  };
  Material dielectric = partial(glass) ? body() : GlassOf(context, from, base);
  if (partial(glass) && glass.number > 0) {
    dielectric = GltfMixture(context, std::move(dielectric), GlassOf(context, from, base), glass);
  }
  if (!metal.texture && !(metal.number > 0)) return dielectric;
  Material metallic = NamedPart(base, "metal");
  metallic.metallic = 1;
  if (textured) metallic.roughness_texture = WithFullMetal(context, *base.roughness_texture);
  return GltfMixture(context, std::move(dielectric),
                     LayeredGltf(context, from, std::move(metallic)), metal);
}

}  // namespace skywave
