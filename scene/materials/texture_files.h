// Image files of textures: each is read once, however many materials use it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "image/image.h"
#include "scene/scene.h"

namespace skywave {

// What a texture may be: small enough that its pyramid can be built in memory.
inline constexpr ReadLimits kTextureLimits = {
    .max_width = 16384, .max_height = 16384, .max_pixels = std::size_t{1} << 26};

struct TextureFiles {
  Scene* scene;  // gets the images
  std::map<std::pair<std::string, Encoding>, std::uint32_t> images = {};
};

// The image of a file in Scene::images. Colours must be finite and not negative: others become 0.
// Throws InputError as ReadTexture does.
std::uint32_t AddTextureImage(TextureFiles& files, const std::string& path, Encoding encoding);

// True if every channel of the image is 1.
bool IsWhite(const Image& image);

// Adds a picture from memory.
std::uint32_t AddTextureImage(Scene& scene, Image image);

// (u, v) with v upwards, as OBJ and pbrt have it, scaled and moved, to Texture's.
glm::mat3x2 UpwardTextureTransform(const glm::vec2& scale, const glm::vec2& offset);

}  // namespace skywave
