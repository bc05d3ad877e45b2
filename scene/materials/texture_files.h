// The image file of a texture is read once, however many materials use it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "image/compact_image.h"
#include "scene/scene.h"

namespace skywave {

// A texture must be small enough that its pyramid can be built in memory.
inline constexpr ReadLimits kTextureLimits = {
    .max_width = 16384, .max_height = 16384, .max_pixels = std::size_t{1} << 26};

struct TextureFiles {
  Scene* scene;  // receives the images
  std::map<std::pair<std::string, Encoding>, std::uint32_t> images = {};
  std::size_t baked_texels = 0;  // of images made from several files
};

// Returns the index in Scene::images of the image of a file. Colours must be finite and not
// negative, and RepairRadiance makes them so. Throws InputError as ReadTexture does.
std::uint32_t AddTextureImage(TextureFiles& files, const std::string& path, Encoding encoding);

// Returns whether every channel of the image is 1.
bool IsWhite(const CompactImage& image);

// Adds an image from memory and returns its index.
std::uint32_t AddTextureImage(Scene& scene, CompactImage image);

// Returns the transform of a Texture for (u, v) with v upwards, as OBJ and pbrt have it, which are
// scaled and moved.
glm::mat3x2 UpwardTextureTransform(const glm::vec2& scale, const glm::vec2& offset);

}  // namespace skywave
