#include "scene/pbrt/surface_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace skywave {
namespace {

float Mean(const glm::vec3& v) { return (v.x + v.y + v.z) / 3; }

}  // namespace

std::uint32_t CopyPbrtTexture(PbrtReader& reader, std::uint32_t texture, TextureUse use) {
  Texture copy = reader.scene.textures[texture];
  copy.use = use;
  reader.scene.textures.push_back(copy);
  return static_cast<std::uint32_t>(reader.scene.textures.size() - 1);
}

std::uint32_t MaterialWithPbrtAlpha(PbrtReader& reader, PbrtParameters& parameters,
                                    std::uint32_t material) {
  const auto image = FindImageTexture(parameters, "alpha", reader.float_textures);
  const auto value =
      image ? image->value : FindColor(parameters, "alpha", reader.float_textures, reader.warnings);
  const float opacity = value ? std::clamp(Mean(*value), 0.0f, 1.0f) : 1.0f;
  if (!image && opacity == 1) return material;
  const auto key = std::tuple(material, opacity, image ? *image->image : ~0u);
  if (const auto found = reader.materials_with_alpha.find(key);
      found != reader.materials_with_alpha.end()) {
    return found->second;
  }
  Material copy = reader.scene.materials[material];
  copy.opacity *= opacity;
  if (image) copy.opacity_texture = CopyPbrtTexture(reader, *image->image, TextureUse::kOpacity);
  reader.scene.materials.push_back(std::move(copy));
  const auto index = static_cast<std::uint32_t>(reader.scene.materials.size() - 1);
  reader.materials_with_alpha.emplace(key, index);
  return index;
}

void ReadPbrtRelief(PbrtReader& reader, PbrtParameters& parameters, Material& material) {
  for (const char* name : {"displacement", "bumpmap"}) {
    if (const auto heights = FindImageTexture(parameters, name, reader.float_textures)) {
      material.normal_texture = CopyPbrtTexture(reader, *heights->image, TextureUse::kHeights);
      material.normal_scale = Mean(heights->value.value_or(glm::vec3(1)));
    } else if (const auto solid = FindSolidTexture(parameters, name, reader.float_textures)) {
      reader.solids.push_back({.use = PbrtSolidUse::kHeight, .value = solid->solid});
    } else {
      // A constant height has no effect; this names values that are not understood.
      FindColor(parameters, name, reader.float_textures, reader.warnings);
    }
  }
  if (const auto file = FindString(parameters, "normalmap")) {
    Texture texture;
    texture.use = TextureUse::kPbrtNormals;
    try {
      const std::string path = ResolvePbrtPath(reader, *file, parameters.position);
      texture.image = AddTextureImage(reader.texture_files, path, Encoding::kLinear);
    } catch (const InputError& error) {
      AddMissing(reader.warnings, parameters.position, parameters.directive + ": normalmap", error,
                 "left out");
      return;
    }
    texture.transform = UpwardTextureTransform({1, 1}, {0, 0});
    reader.scene.textures.push_back(texture);
    material.normal_texture = static_cast<std::uint32_t>(reader.scene.textures.size() - 1);
    material.normal_scale = 1;
    // As in pbrt, the map replaces heights, those in space too.
    std::erase_if(reader.solids, [](auto& solid) { return solid.use == PbrtSolidUse::kHeight; });
  }
}

}  // namespace skywave
