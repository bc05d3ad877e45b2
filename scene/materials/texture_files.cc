#include "scene/materials/texture_files.h"

namespace skywave {

std::uint32_t AddTextureImage(Scene& scene, CompactImage image) {
  image.Repair();
  scene.images.push_back(std::move(image));
  return static_cast<std::uint32_t>(scene.images.size() - 1);
}

std::uint32_t AddTextureImage(TextureFiles& files, const std::string& path, Encoding encoding) {
  const auto key = std::pair(path, encoding);
  if (const auto found = files.images.find(key); found != files.images.end()) return found->second;
  const std::uint32_t image =
      AddTextureImage(*files.scene, ReadCompactTexture(path, encoding, kTextureLimits));
  files.images.emplace(key, image);
  return image;
}

bool IsWhite(const CompactImage& image) {
  for (std::size_t i = 0; i < image.values(); ++i) {
    if (image.Value(i) != 1) return false;
  }
  return true;
}

glm::mat3x2 UpwardTextureTransform(const glm::vec2& scale, const glm::vec2& offset) {
  return {scale.x, 0, 0, -scale.y, offset.x, 1 - offset.y};
}

}  // namespace skywave
