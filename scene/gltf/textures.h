// The textures of a glTF file's materials, and the values of their extensions.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "image/image.h"
#include "scene/materials/texture_baking.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

using GltfImageKey = std::pair<int, Encoding>;  // number in the file

// Makes the textures of one material after the other.
struct GltfTextures {
  const tinygltf::Model& model;
  const std::string& path;
  Scene& scene;
  Warnings& warnings;
  std::string material = {};      // the name of the one that is being made
  std::vector<int> uv_sets = {};  // that its textures use, two at most: a mesh has so many (UvSet)
  // What has been made of the images of the file, so that each is decoded once.
  std::map<GltfImageKey, std::uint32_t> images = {};
  std::map<GltfImageKey, CompactImage> decoded = {};  // before their first use (DecodeAhead)
  // Set: images are noted here, and none is decoded; each is a white texel.
  std::set<GltfImageKey>* wanted = nullptr;
  std::map<std::tuple<std::uint32_t, int, float>, std::uint32_t> channels = {};
  UnfilteredImages unfiltered{.name = "NEAREST"};
  std::size_t baked_texels = 0;
};

// Decodes images on all threads, for their first use. What cannot be decoded is tried again then,
// where the material that wants it can be named.
void DecodeAhead(const std::set<GltfImageKey>& wanted, GltfTextures& textures);

// Adds a warning that names the file and the material.
void WarnOfMaterial(GltfTextures& textures, const std::string& text);

// A reference to a texture, wherever it stands in the file.
struct GltfTextureInfo {
  int index = -1, uv_set = 0;
  std::optional<glm::mat3x2> transform = {};
  bool operator==(const GltfTextureInfo&) const = default;
};
GltfTextureInfo TextureInfo(const tinygltf::TextureInfo& from);
GltfTextureInfo TextureInfo(const tinygltf::NormalTextureInfo& from);
// Returns that of a member of an extension; its index is -1 where there is none.
GltfTextureInfo TextureInfo(const tinygltf::Value& extension, const char* name);

// Returns the index in Scene::textures of a new texture, or nothing where the file names none. One
// that cannot be read is left out with a warning. Throws InputError(path) for a texture that does
// not exist.
std::optional<std::uint32_t> AddGltfTexture(GltfTextures& textures, const GltfTextureInfo& info,
                                            Encoding encoding, TextureUse use);

// The numbers in a channel of a texture times a factor: one number, where they are all the same, or
// else a texture that has them in all of its channels.
struct GltfShare {
  float number;
  std::optional<std::uint32_t> texture = {};
};
GltfShare AddGltfShare(GltfTextures& textures, const GltfTextureInfo& info, int channel,
                       float factor);  // channel 3 is alpha

// Returns the object of an extension of a material, or null if it lacks it.
const tinygltf::Value* GltfExtension(const tinygltf::Material& from, const char* name);
// These return a member of an extension, or `otherwise` where it has none of that kind.
double GltfNumber(const tinygltf::Value& object, const char* name, double otherwise);
// An index, which is -1 for none. Numbers that no int holds are those of something that is missing.
int GltfIndex(const tinygltf::Value& object, const char* name, int otherwise);
glm::vec3 GltfColor(const tinygltf::Value& object, const char* name, const glm::vec3& otherwise);

}  // namespace skywave
