#include "scene/gltf/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "scene/gltf/buffers.h"
#include "scene/gltf/compression.h"

namespace skywave {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMostFileBytes = std::size_t{2} << 30;  // of a file

// The extensions that a file may require; those of materials (KHR_materials_*) are named with the
// materials that have them, and never refused; textures of KHR_texture_basisu are left out by name.
constexpr std::string_view kRequirable[] = {"EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
                                            "EXT_texture_webp",        "KHR_draco_mesh_compression",
                                            "KHR_lights_punctual",     "KHR_mesh_quantization",
                                            "KHR_meshopt_compression", "KHR_node_visibility",
                                            "KHR_texture_basisu",      "KHR_texture_transform"};

// ---- The container ----

std::uint32_t Word(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

// The parts of a file: a .glb has a chunk of JSON and, as a rule, one that is its first buffer.
struct Container {
  std::string_view json;
  std::optional<std::string_view> binary;
};

Container ChunksOf(std::string_view bytes, const std::string& path) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;
  if (bytes.size() < kHeader) FailGltf(path, "is a GLB file that ends in its header");
  if (const std::uint32_t version = Word(bytes, 4); version != 2) {
    FailGltf(path,
             fmt::format("is a GLB file of version {}, and only version 2 can be read", version));
  }
  Container container;
  const std::size_t end = std::min<std::size_t>(Word(bytes, 8), bytes.size());
  if (end < Word(bytes, 8)) {
    FailGltf(path, fmt::format("ends after {} of its {} bytes", bytes.size(), Word(bytes, 8)));
  }
  if (end < kHeader) FailGltf(path, fmt::format("says that it has {} bytes, header included", end));
  std::size_t at = kHeader;
  while (end - at >= kChunkHeader) {
    const std::size_t length = Word(bytes, at);
    const std::uint32_t type = Word(bytes, at + 4);
    at += kChunkHeader;
    if (length > end - at) FailGltf(path, "has a chunk that extends beyond the file");
    const std::string_view chunk = bytes.substr(at, length);
    if (type == kJson && container.json.empty()) container.json = chunk;
    if (type == kBinary && !container.binary) container.binary = chunk;
    at += std::min((length + 3) / 4 * 4, end - at);
  }
  return container;
}

Container ContainerOf(std::string_view bytes, const std::string& path) {
  if (bytes.starts_with("glTF")) return ChunksOf(bytes, path);
  if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
  return {.json = bytes, .binary = std::nullopt};
}

// Throws InputError unless this is a version 2 file that needs nothing unknown.
void CheckVersion(const json& document, const std::string& path) {
  if (!document.is_object()) FailGltf(path, "is no glTF file: it is no JSON object");
  const json asset = document.value("asset", json::object());
  // Old programs write numbers.
  const auto text_of = [&](const char* key) -> std::string {
    if (!asset.is_object() || !asset.contains(key)) return "";
    return asset[key].is_string() ? asset[key].get<std::string>() : JsonText(asset[key]);
  };
  const std::string version = text_of("version");
  // Files of version 1 name things by words, in objects, and some of them lack the version.
  const bool named = document.contains("meshes") && document["meshes"].is_object();
  if (version.starts_with("1") || (version.empty() && named)) {
    FailGltf(path, "is glTF 1.0, which is not supported: convert it to 2.0");
  }
  if (version.empty()) FailGltf(path, "is no glTF file: it has no asset.version");
  const std::string least = text_of("minVersion");
  if (!version.starts_with("2.") || !(least.empty() || least == "2.0" || least == "2")) {
    FailGltf(path, fmt::format("needs glTF {}, and only 2.0 is supported",
                               (version.starts_with("2.") ? least : version).substr(0, 20)));
  }
  for (const json& extension : document.value("extensionsRequired", json::array())) {
    const std::string name = extension.get<std::string>();
    if (name.starts_with("KHR_materials_")) continue;
    if (std::find(std::begin(kRequirable), std::end(kRequirable), name) == std::end(kRequirable)) {
      FailGltf(path, fmt::format("needs the extension {}, which is not supported", name));
    }
  }
}

// ---- Files: only those below the glTF file's folder are read ----

struct Files {
  fs::path folder;
  std::vector<std::string>* buffers;
  std::string refused;  // the first name outside the folder
};

constexpr std::string_view kBufferName = "skywave-buffer-";  // and its number, for tinygltf

// Returns the buffer that tinygltf asks for by that name, or null.
std::string* BufferOf(const Files& files, std::string_view name) {
  if (name.starts_with("./")) name.remove_prefix(2);
  if (!name.starts_with(kBufferName)) return nullptr;
  // Names that a file has itself may begin likewise.
  name.remove_prefix(kBufferName.size());
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool whole = error == std::errc() && end == name.data() + name.size();
  return whole && index < files.buffers->size() ? &(*files.buffers)[index] : nullptr;
}

// Returns the file of that name, or nothing. tinygltf may prefix names with "./".
std::optional<fs::path> Inside(Files& files, const std::string& name) {
  // tinygltf takes data of types that it does not know, such as WebP, for names of files.
  if (name.starts_with("data:") || name.starts_with("./data:")) return std::nullopt;
  const fs::path relative(name);
  const bool leaves = relative.is_absolute() || name.find('\\') != std::string::npos ||
                      name.find(':') != std::string::npos ||
                      std::find(relative.begin(), relative.end(), "..") != relative.end() ||
                      name.starts_with(".//");
  if (leaves) {
    if (files.refused.empty()) files.refused = name;
    return std::nullopt;
  }
  return files.folder / relative;
}

bool Exists(const std::string& name, void* user) {
  Files& files = *static_cast<Files*>(user);
  if (BufferOf(files, name) != nullptr) return true;
  const auto path = Inside(files, name);
  std::error_code ignored;
  return path && fs::is_regular_file(*path, ignored);
}
// The default function passes names through shell expansion.
std::string KeepPath(const std::string& name, void*) { return name; }
bool ReadWhole(std::vector<unsigned char>* out, std::string* error, const std::string& name,
               void* user) {
  Files& files = *static_cast<Files*>(user);
  if (std::string* const buffer = BufferOf(files, name)) {
    out->assign(buffer->begin(), buffer->end());
    buffer->clear(), buffer->shrink_to_fit();
    return true;
  }
  const auto path = Inside(files, name);
  if (!path) return false;
  try {
    const std::string bytes = ReadFile(path->string(), kMostFileBytes);
    out->assign(bytes.begin(), bytes.end());
    return true;
  } catch (const InputError& reason) {
    if (error != nullptr) *error += reason.what();
    return false;
  }
}

// tinygltf takes its own functions instead of ours if one is missing. Versions since 2.9 have one
// more.
template <class Callbacks>
Callbacks CallbacksOf(Files& files) {
  Callbacks callbacks = {};
  callbacks.FileExists = Exists;
  callbacks.ExpandFilePath = KeepPath;
  callbacks.ReadWholeFile = ReadWhole;
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&,
                                void*) { return false; };
  if constexpr (requires { callbacks.GetFileSizeInBytes; }) {
    callbacks.GetFileSizeInBytes = [](std::size_t* size, std::string*, const std::string& name,
                                      void* user) {
      Files& from = *static_cast<Files*>(user);
      if (const std::string* const buffer = BufferOf(from, name)) {
        *size = buffer->size();
        return true;
      }
      const auto path = Inside(from, name);
      std::error_code error;
      *size = path ? fs::file_size(*path, error) : 0;
      return path && !error;
    };
  }
  callbacks.user_data = &files;
  return callbacks;
}

bool IsHexDigit(char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; }

// Returns the bytes of a buffer, of which at least as many have to be there as the file says.
std::string ReadBuffer(const json& buffer, std::size_t index, const Container& container,
                       Files& files, const std::string& path) {
  const std::size_t length = buffer.at("byteLength").get<std::size_t>();
  std::string bytes;
  if (!buffer.contains("uri")) {
    // Buffers after the first one may stand for what is compressed in another one.
    if (index != 0 || !container.binary) return "";
    bytes = *container.binary;
  } else if (const std::string uri = buffer["uri"].get<std::string>(); uri.starts_with("data:")) {
    std::vector<unsigned char> data;
    std::string type;
    if (!tinygltf::DecodeDataURI(&data, type, uri, 0, false)) {
      FailGltf(path, fmt::format("buffer {} has data that cannot be decoded", index));
    }
    bytes.assign(data.begin(), data.end());
  } else {
    std::string name;
    for (std::size_t i = 0; i < uri.size(); ++i) {
      const bool escaped =
          uri[i] == '%' && i + 2 < uri.size() && IsHexDigit(uri[i + 1]) && IsHexDigit(uri[i + 2]);
      name += escaped ? char(std::stoi(uri.substr(i + 1, 2), nullptr, 16)) : uri[i];
      if (escaped) i += 2;
    }
    const auto file = Inside(files, name);
    if (!file) FailGltf(path, fmt::format("names \"{}\", which is not below its folder", name));
    try {
      bytes = ReadFile(file->string(), kMostFileBytes);
    } catch (const InputError& error) {
      FailGltf(path, fmt::format("buffer {}: {}", index, error.what()));
    }
  }
  if (bytes.size() < length) {
    FailGltf(path, fmt::format("buffer {} has {} bytes, and the file says {}", index, bytes.size(),
                               length));
  }
  bytes.resize(length);
  return bytes;
}

// ---- tinygltf ----

// Images stay encoded as in the file. Those in buffer views are looked up only once their range has
// been checked, because tinygltf has not checked it.
bool KeepImage(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
               const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

// Gives the accessors of indices that have no view one of zeros, as the specification has it.
void AddViewsOfZeros(GltfSource& source, const std::string& path) {
  json& document = source.json;
  if (!document.contains("meshes") || !document.contains("accessors")) return;
  std::optional<std::size_t> zeros;  // the buffer of all of them
  for (const json& mesh : document["meshes"]) {
    for (const json& primitive : mesh.value("primitives", json::array())) {
      if (!primitive.contains("indices")) continue;
      json& accessors = document["accessors"];
      const auto index = primitive["indices"].get<std::size_t>();
      if (index >= accessors.size() || accessors[index].contains("bufferView")) continue;
      constexpr std::size_t kLargestIndex = 4;
      const auto count = accessors[index].at("count").get<std::size_t>();
      if (count > kMostGltfZeros) {
        FailGltf(path, fmt::format("accessor {} has {} elements without a buffer view, and {} are "
                                   "the most that are read",
                                   index, count, kMostGltfZeros));
      }
      if (!zeros) {
        zeros = source.buffers.size();
        source.buffers.emplace_back();
      }
      std::string& bytes = source.buffers[*zeros];
      bytes.resize(std::max(bytes.size(), count * kLargestIndex));
      document["bufferViews"].push_back(
          {{"buffer", *zeros}, {"byteLength", count * kLargestIndex}});
      accessors[index]["bufferView"] = document["bufferViews"].size() - 1;
    }
  }
}

// Returns the array of KHR_lights_punctual, or an empty one.
json& PunctualLightsOf(json& document) {
  static json none;
  none = json::array();
  const json::json_pointer place("/extensions/KHR_lights_punctual/lights");
  return document.contains(place) ? document[place] : none;
}

// tinygltf refuses whole files for these, and takes data of types that it does not know for names.
void Complete(GltfSource& source) {
  json& document = source.json;
  json buffers = json::array();
  for (std::size_t i = 0; i < source.buffers.size(); ++i) {
    source.buffers[i].resize(std::max<std::size_t>(source.buffers[i].size(), 1));
    buffers.push_back(
        {{"byteLength", source.buffers[i].size()}, {"uri", fmt::format("{}{}", kBufferName, i)}});
  }
  document["buffers"] = std::move(buffers);
  for (json& light : PunctualLightsOf(document)) {
    if (light.value("type", "") == "spot" && !light.contains("spot"))
      light["spot"] = json::object();
  }
  if (!document.contains("images")) return;
  for (json& image : document["images"]) {
    if (!image.contains("uri") && !image.contains("bufferView")) image["uri"] = "";
    if (image.contains("uri") && image.contains("bufferView")) image.erase("uri");
    constexpr std::string_view kData = "data:";
    if (!image.contains("uri") || !image["uri"].get_ref<const std::string&>().starts_with(kData)) {
      continue;
    }
    std::string& uri = image["uri"].get_ref<std::string&>();
    const std::size_t end = uri.find(';');
    if (end != std::string::npos) uri.replace(0, end, "data:image/png");
  }
}

tinygltf::Model ParseModel(GltfSource& source, Files& files, const std::string& path) {
  AddViewsOfZeros(source, path);
  Complete(source);
  files.buffers = &source.buffers;
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(CallbacksOf<tinygltf::FsCallbacks>(files));
  loader.SetImageLoader(KeepImage, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  const std::string text = JsonText(source.json);
  const bool loaded = loader.LoadASCIIFromString(&model, &error, &warning, text.c_str(),
                                                 static_cast<unsigned int>(text.size()), "");
  if (!files.refused.empty()) {
    FailGltf(path, fmt::format("names \"{}\", which is not below its folder", files.refused));
  }
  if (!loaded) {
    std::replace(error.begin(), error.end(), '\n', ' ');
    FailGltf(path, "is no glTF file to read: " + error.substr(0, 300));
  }
  return model;
}

}  // namespace

tinygltf::Model LoadGltf(const std::string& bytes, const std::string& path, Warnings& warnings) {
  try {
    const Container container = ContainerOf(bytes, path);
    GltfSource source{ParseJson(container.json), {}};
    CheckVersion(source.json, path);
    Files files{fs::path(path).parent_path(), &source.buffers, ""};
    for (const json& buffer : source.json.value("buffers", json::array())) {
      source.buffers.push_back(ReadBuffer(buffer, source.buffers.size(), container, files, path));
    }
    DecodeMeshoptViews(source, path, warnings);
    DecodeDracoPrimitives(source, path, warnings);
    return ParseModel(source, files, path);
  } catch (const json::exception& error) {
    // Types may be unexpected in any place, also in tinygltf, which uses the same library.
    std::string reason = error.what();
    FailGltf(path, "is no glTF file to read: " + reason.substr(0, 300));
  }
}

}  // namespace skywave
