#include "scene/gltf/specular_glossiness.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

constexpr float kDielectric = 0.04f;

float Brightness(const glm::vec3& c) {
  return std::sqrt(glm::dot(glm::vec3(0.299f, 0.587f, 0.114f), c * c));
}

struct MetallicColor {
  glm::vec3 base;
  float metallic;
};
MetallicColor Convert(const glm::vec3& diffuse, const glm::vec3& specular) {
  const float left = 1 - std::max({specular.x, specular.y, specular.z});
  const float bright = Brightness(specular);
  float metallic = 0;
  if (bright > kDielectric) {
    const float b = Brightness(diffuse) * left / (1 - kDielectric) + bright - 2 * kDielectric;
    const float root = std::sqrt(std::max(b * b - 4 * kDielectric * (kDielectric - bright), 0.0f));
    metallic = std::clamp((root - b) / (2 * kDielectric), 0.0f, 1.0f);
  }
  constexpr float kTiny = 1e-6f;
  const float body = 1 - metallic;
  const glm::vec3 of_diffuse = diffuse * (left / (1 - kDielectric) / std::max(body, kTiny));
  const glm::vec3 of_specular = (specular - kDielectric * body) / std::max(metallic, kTiny);
  const glm::vec3 base = glm::mix(of_diffuse, of_specular, metallic * metallic);
  return {glm::clamp(base, 0.0f, 1.0f), metallic};
}

// A picture of the file, or white.
struct Source {
  const CompactImage* image;
  glm::vec4 At(int x, int y, int width, int height) const {
    if (image == nullptr) return glm::vec4(1);
    const auto p = image->Pixel(x * image->width / width, y * image->height / height);
    return {p[0], p[1], p[2], 1};
  }
};

}  // namespace

double SpecularGlossinessAlpha(const tinygltf::Value& extension) {
  if (!extension.Has("diffuseFactor") || !extension.Get("diffuseFactor").IsArray() ||
      extension.Get("diffuseFactor").ArrayLen() < 4) {
    return 1;
  }
  return extension.Get("diffuseFactor").Get(3).GetNumberAsDouble();
}

void SetSpecularGlossiness(GltfTextures& textures, const tinygltf::Value& extension,
                           Material& material) {
  const auto color_of = [&](const char* name) {
    return glm::clamp(GltfColor(extension, name, glm::vec3(1)), 0.0f, 1.0f);
  };
  const glm::vec3 diffuse = color_of("diffuseFactor"), specular = color_of("specularFactor");
  const float glossiness =
      std::clamp(float(GltfNumber(extension, "glossinessFactor", 1)), 0.0f, 1.0f);
  const auto [base, metallic] = Convert(diffuse, specular);
  material.reflectance = base, material.metallic = metallic;
  material.alpha = (1 - glossiness) * (1 - glossiness);

  const GltfTextureInfo diffuse_info = TextureInfo(extension, "diffuseTexture");
  const GltfTextureInfo gloss_info = TextureInfo(extension, "specularGlossinessTexture");
  const auto colors = AddGltfTexture(textures, diffuse_info, Encoding::kSrgb, TextureUse::kColor);
  const auto gloss = AddGltfTexture(textures, gloss_info, Encoding::kSrgb, TextureUse::kColor);
  const auto gloss_alpha =
      gloss ? AddGltfTexture(textures, gloss_info, Encoding::kAlpha, TextureUse::kColor)
            : std::nullopt;
  if (!colors && !gloss) return;
  if (colors && gloss && diffuse_info.transform != gloss_info.transform) {
    WarnOfMaterial(textures,
                   "its two textures have different transforms: that of the diffuse one "
                   "is used");
  }
  Scene& scene = textures.scene;
  if (colors && gloss && scene.textures[*colors].uv_set != scene.textures[*gloss].uv_set) {
    WarnOfMaterial(textures,
                   "its two textures have different texture coordinates: those of the diffuse one "
                   "are used");
  }
  const auto source = [&](const std::optional<std::uint32_t>& texture) {
    return Source{texture ? &scene.images[scene.textures[*texture].image] : nullptr};
  };
  const Source of_diffuse = source(colors), of_specular = source(gloss),
               of_gloss = source(gloss_alpha);
  int width = 1, height = 1;
  for (const Source& from : {of_diffuse, of_specular}) {
    if (from.image == nullptr) continue;
    width = std::max(width, from.image->width), height = std::max(height, from.image->height);
  }
  Image base_colors(width, height), widths(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto texel = Convert(diffuse * glm::vec3(of_diffuse.At(x, y, width, height)),
                                 specular * glm::vec3(of_specular.At(x, y, width, height)));
      float* const color = base_colors.Pixel(x, y);
      for (int c = 0; c < 3; ++c) color[c] = texel.base[c];
      float* const rough = widths.Pixel(x, y);
      rough[0] = 1;
      rough[1] = 1 - glossiness * of_gloss.At(x, y, width, height).x;
      rough[2] = texel.metallic;
    }
  }
  Texture texture = scene.textures[colors ? *colors : *gloss];
  const auto add = [&](Image image) {
    texture.image = AddTextureImage(scene, std::move(image));
    scene.textures.push_back(texture);
    return std::uint32_t(scene.textures.size() - 1);
  };
  material.color_texture = add(std::move(base_colors));
  material.roughness_texture = add(std::move(widths));
  material.reflectance = glm::vec3(1), material.metallic = 1, material.alpha = 1;
}

}  // namespace skywave
