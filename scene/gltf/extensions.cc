#include "scene/gltf/extensions.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace skywave {

float GltfFraction(GltfTextures& context, const char* name, double value) {
  if (value >= 0 && value <= 1) return float(value);
  WarnOfMaterial(context, fmt::format("{} {} is clamped to [0, 1]", name, value));
  return value > 0 ? 1.0f : 0.0f;  // NaN becomes 0
}
float GltfFractionOf(GltfTextures& context, const tinygltf::Value& extension, const char* name,
                     double otherwise) {
  return GltfFraction(context, name, GltfNumber(extension, name, otherwise));
}

std::optional<std::uint32_t> GltfTextureOf(GltfTextures& context, const tinygltf::Value& extension,
                                           const char* name, Encoding encoding) {
  return AddGltfTexture(context, TextureInfo(extension, name), encoding, TextureUse::kColor);
}

float GltfPositive(GltfTextures& context, const tinygltf::Value& extension, const char* name,
                   double otherwise) {
  const double value = GltfNumber(extension, name, otherwise);
  if (value >= 0 && value <= 1e6) return float(value);
  WarnOfMaterial(context,
                 fmt::format("{} {} is not supported: {} is used", name, value, otherwise));
  return float(otherwise);
}

Material GltfMixture(GltfTextures& context, Material first, Material second,
                     const GltfShare& share) {
  std::vector<Material>& materials = context.scene.materials;
  materials.push_back(std::move(first)), materials.push_back(std::move(second));
  const auto row = std::uint32_t(materials.size());
  Material mixed = {.mixture = Mixture{row - 2, row - 1, share.number}};
  mixed.mixture_texture = share.texture;
  return mixed;
}
Material NamedPart(const Material& base, const char* part) {
  Material named = base;
  named.name = fmt::format("{} ({})", base.name, part);
  return named;
}

}  // namespace skywave
