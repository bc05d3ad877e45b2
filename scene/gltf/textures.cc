#include "scene/gltf/textures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "scene/gltf/buffers.h"
#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

constexpr const char* kTransform = "KHR_texture_transform";

// Returns what a file says of the numbers [x, y], or `otherwise`.
glm::dvec2 Pair(const tinygltf::Value& object, const char* name, const glm::dvec2& otherwise) {
  if (!object.IsObject() || !object.Has(name) || !object.Get(name).IsArray() ||
      object.Get(name).ArrayLen() != 2) {
    return otherwise;
  }
  const tinygltf::Value& pair = object.Get(name);
  if (!pair.Get(0).IsNumber() || !pair.Get(1).IsNumber()) return otherwise;
  return {pair.Get(0).GetNumberAsDouble(), pair.Get(1).GetNumberAsDouble()};
}

// Applies KHR_texture_transform: scale, counter-clockwise rotation in the picture, then
// translation.
void SetTransform(const tinygltf::Value& extension, GltfTextureInfo& info) {
  const glm::dvec2 scale = Pair(extension, "scale", {1, 1});
  const glm::dvec2 offset = Pair(extension, "offset", {0, 0});
  const double angle = GltfNumber(extension, "rotation", 0);
  const double c = std::cos(angle), s = std::sin(angle);
  info.transform = glm::mat3x2(
      glm::dmat3x2(c * scale.x, -s * scale.x, s * scale.y, c * scale.y, offset.x, offset.y));
  info.uv_set = GltfIndex(extension, "texCoord", info.uv_set);
}

template <class Info>
GltfTextureInfo InfoOf(const Info& from) {
  GltfTextureInfo info = {.index = from.index, .uv_set = from.texCoord};
  const auto found = from.extensions.find(kTransform);
  if (from.index >= 0 && found != from.extensions.end()) SetTransform(found->second, info);
  return info;
}

// Throws InputError for an image that is not there or cannot be decoded.
CompactImage DecodeGltfImage(const GltfTextures& textures, int index, Encoding encoding) {
  if (index < 0 || std::size_t(index) >= textures.model.images.size()) {
    throw InputError(InputPosition::File(textures.path),
                     fmt::format("there is no image {}", index));
  }
  const tinygltf::Image& image = textures.model.images[std::size_t(index)];
  const std::string name = fmt::format("{}, image {}", textures.path, index);
  std::string_view bytes(reinterpret_cast<const char*>(image.image.data()), image.image.size());
  if (image.bufferView >= 0) bytes = GltfBytes(textures.model, image.bufferView, textures.path);
  if (bytes.empty()) throw InputError(InputPosition::File(name), "is missing or empty");
  if (!IsGltfImage(bytes)) {
    throw InputError(InputPosition::File(name), "is neither PNG, JPEG nor WebP");
  }
  return DecodeCompactTexture(name, bytes, encoding, kTextureLimits);
}

Image WhiteTexel() {
  Image image(1, 1);
  image.rgb = {1, 1, 1};
  return image;
}

std::uint32_t AddImage(GltfTextures& textures, int index, Encoding encoding) {
  const GltfImageKey key(index, encoding);
  if (const auto found = textures.images.find(key); found != textures.images.end()) {
    return found->second;
  }
  CompactImage image;
  if (textures.wanted != nullptr) {
    textures.wanted->insert(key);
    image = WhiteTexel();
  } else if (const auto ahead = textures.decoded.extract(key)) {
    image = std::move(ahead.mapped());
  } else {
    image = DecodeGltfImage(textures, index, encoding);
  }
  const std::uint32_t added = AddTextureImage(textures.scene, std::move(image));
  textures.images.emplace(key, added);
  return added;
}

// Returns the image of a texture: that of EXT_texture_webp, which stands for the same in PNG or
// JPEG.
int SourceOf(const tinygltf::Texture& from) {
  const auto found = from.extensions.find("EXT_texture_webp");
  if (found == from.extensions.end()) return from.source;
  return GltfIndex(found->second, "source", from.source);
}

TextureWrap Wrap(int gl) {
  if (gl == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureWrap::kClamp;
  if (gl == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return TextureWrap::kMirror;
  return TextureWrap::kRepeat;
}

// Returns which of the coordinates of its meshes the material's textures have by this set of the
// file. There are two: the sets of its first textures.
UvSet ChooseUvSet(GltfTextures& textures, int set) {
  std::vector<int>& sets = textures.uv_sets;
  const auto known = std::find(sets.begin(), sets.end(), set);
  if (known != sets.end()) return UvSet(known - sets.begin());
  if (sets.size() == 2) {
    WarnOfMaterial(textures,
                   fmt::format("more than two sets of texture coordinates in a material are not "
                               "supported: set {} is used for set {}",
                               sets[0], set));
    return UvSet::kFirst;
  }
  sets.push_back(set);
  return UvSet(sets.size() - 1);
}

}  // namespace

void DecodeAhead(const std::set<GltfImageKey>& wanted, GltfTextures& textures) {
  const std::vector<GltfImageKey> keys(wanted.begin(), wanted.end());
  std::vector<std::optional<CompactImage>> images(keys.size());
  tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t i) {
    try {
      images[i] = DecodeGltfImage(textures, keys[i].first, keys[i].second);
    } catch (const InputError&) {
      images[i].reset();
    }
  });
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (images[i]) textures.decoded.emplace(keys[i], std::move(*images[i]));
  }
}

void WarnOfMaterial(GltfTextures& textures, const std::string& text) {
  AddWarningOf(textures.warnings, InputPosition::File(textures.path), "material", textures.material,
               text);
}

double GltfNumber(const tinygltf::Value& object, const char* name, double otherwise) {
  if (!object.IsObject() || !object.Has(name) || !object.Get(name).IsNumber()) return otherwise;
  return object.Get(name).GetNumberAsDouble();
}
int GltfIndex(const tinygltf::Value& object, const char* name, int otherwise) {
  constexpr double kLargest = std::numeric_limits<int>::max();
  return int(std::clamp(GltfNumber(object, name, otherwise), -1.0, kLargest));
}

glm::vec3 GltfColor(const tinygltf::Value& object, const char* name, const glm::vec3& otherwise) {
  if (!object.IsObject() || !object.Has(name) || !object.Get(name).IsArray() ||
      object.Get(name).ArrayLen() < 3) {
    return otherwise;
  }
  glm::vec3 color;
  for (int c = 0; c < 3; ++c) {
    const tinygltf::Value& channel = object.Get(name).Get(c);
    color[c] = channel.IsNumber() ? float(channel.GetNumberAsDouble()) : otherwise[c];
  }
  return color;
}

const tinygltf::Value* GltfExtension(const tinygltf::Material& from, const char* name) {
  const auto found = from.extensions.find(name);
  return found == from.extensions.end() ? nullptr : &found->second;
}

GltfTextureInfo TextureInfo(const tinygltf::TextureInfo& from) { return InfoOf(from); }
GltfTextureInfo TextureInfo(const tinygltf::NormalTextureInfo& from) { return InfoOf(from); }
GltfTextureInfo TextureInfo(const tinygltf::Value& extension, const char* name) {
  if (!extension.IsObject() || !extension.Has(name)) return {};
  const tinygltf::Value& from = extension.Get(name);
  GltfTextureInfo info = {.index = GltfIndex(from, "index", -1),
                          .uv_set = GltfIndex(from, "texCoord", 0)};
  if (info.index < 0 || !from.Has("extensions")) return info;
  const tinygltf::Value& extensions = from.Get("extensions");
  if (extensions.IsObject() && extensions.Has(kTransform)) {
    SetTransform(extensions.Get(kTransform), info);
  }
  return info;
}

std::optional<std::uint32_t> AddGltfTexture(GltfTextures& textures, const GltfTextureInfo& info,
                                            Encoding encoding, TextureUse use) {
  if (info.index < 0) return std::nullopt;
  const tinygltf::Model& model = textures.model;
  if (std::size_t(info.index) >= model.textures.size()) {
    WarnOfMaterial(textures, fmt::format("there is no texture {}: it is left out", info.index));
    return std::nullopt;
  }
  const tinygltf::Texture& from = model.textures[std::size_t(info.index)];
  const int source = SourceOf(from);
  if (source < 0) {
    WarnOfMaterial(textures,
                   fmt::format("texture {} has no image that is known{}: left out", info.index,
                               from.extensions.contains("KHR_texture_basisu")
                                   ? " (KHR_texture_basisu is not supported)"
                                   : ""));
    return std::nullopt;
  }
  Texture texture;
  texture.use = use;
  std::string problem;
  try {
    texture.image = AddImage(textures, source, encoding);
  } catch (const InputError& error) {
    problem = error.what();
  }
  if (!problem.empty()) {
    // What was taken for a name may be the data of a picture.
    std::string uri;
    if (std::size_t(source) < model.images.size()) {
      uri = model.images[std::size_t(source)].uri.substr(0, 80);
    }
    const std::string text = fmt::format("texture {} is left out: {}{}", info.index, problem,
                                         uri.empty() ? "" : fmt::format(" (\"{}\")", uri));
    RefuseMissing(textures.warnings, InputPosition::File(textures.path), text);
    WarnOfMaterial(textures, text);
    return std::nullopt;
  }
  texture.uv_set = ChooseUvSet(textures, info.uv_set);
  if (from.sampler >= 0 && std::size_t(from.sampler) < model.samplers.size()) {
    const tinygltf::Sampler& sampler = model.samplers[std::size_t(from.sampler)];
    texture.wrap_u = Wrap(sampler.wrapS), texture.wrap_v = Wrap(sampler.wrapT);
    if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) {
      texture.image =
          textures.unfiltered.Of(texture.image, textures.baked_texels, textures.scene,
                                 [&](const std::string& text) { WarnOfMaterial(textures, text); });
    }
  }
  if (info.transform) texture.transform = *info.transform;
  textures.scene.textures.push_back(texture);
  return std::uint32_t(textures.scene.textures.size() - 1);
}

GltfShare AddGltfShare(GltfTextures& textures, const GltfTextureInfo& info, int channel,
                       float factor) {
  const bool alpha = channel == 3;
  const auto texture = AddGltfTexture(textures, info, alpha ? Encoding::kAlpha : Encoding::kLinear,
                                      TextureUse::kColor);
  if (!texture) return {factor};
  if (alpha) channel = 0;
  Scene& scene = textures.scene;
  const std::uint32_t whole = scene.textures[*texture].image;
  const auto [known, is_new] = textures.channels.try_emplace({whole, channel, factor}, 0);
  if (is_new) {
    Image shares = scene.images[whole].Floats();
    for (std::size_t i = 0; i < shares.rgb.size(); i += 3) {
      std::fill_n(&shares.rgb[i], 3, factor * shares.rgb[i + std::size_t(channel)]);
    }
    known->second = AddTextureImage(scene, std::move(shares));
  }
  const CompactImage& shares = scene.images[known->second];
  const float first = shares.Value(0);
  std::size_t same = 1;
  while (same < shares.values() && shares.Value(same) == first) ++same;
  if (same == shares.values()) {
    scene.textures.pop_back();
    return {first};
  }
  scene.textures[*texture].image = known->second;
  return {1, texture};
}

}  // namespace skywave
