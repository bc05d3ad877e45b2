#include "scene/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/nearest_name.h"
#include "scene/builtin/builtin.h"
#include "scene/gltf/reader.h"
#include "scene/instances.h"
#include "scene/obj/reader.h"
#include "scene/pbrt/reader.h"
#include "scene/shapes/ply.h"

namespace skywave {
namespace {

std::string LowerCaseEnding(std::filesystem::path path) {
  if (path.extension() == ".gz") path.replace_extension();
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

Scene ReadPlyScene(const std::string& path, const ReadOptions&) {
  Mesh mesh = ReadPly(path);
  mesh.name = path;
  Scene scene;
  scene.materials.push_back({.name = "default"});
  scene.meshes.push_back(std::move(mesh));
  return scene;
}

struct SceneFormat {
  std::string_view ending;  // in lower case; files may also be compressed, ENDING.gz
  Scene (*read)(const std::string& path, const ReadOptions& options);
};

constexpr SceneFormat kFormats[] = {
    {".pbrt", ReadPbrt}, {".obj", ReadObj},      {".gltf", ReadGltf},
    {".glb", ReadGltf},  {".ply", ReadPlyScene},
};

Scene ReadByEnding(const std::string& path, const ReadOptions& options) {
  const std::string ending = LowerCaseEnding(path);
  for (const SceneFormat& format : kFormats) {
    if (format.ending == ending) return format.read(path, options);
  }
  throw InputError(InputPosition::File(path),
                   fmt::format("scenes end in {}, not in '{}'", SceneEndings(), ending));
}

// Checks what `options` ask of the animations of a scene, whatever its format.
void CheckAnimation(const std::string& path, const ReadOptions& options, const Scene& scene) {
  std::vector<std::string_view> names;
  for (const AnimationInfo& animation : scene.animations) names.push_back(animation.name);
  const bool found = std::find(names.begin(), names.end(), options.animation) != names.end();
  if (!options.animation.empty() && !found) {
    throw OptionError("animation", options.animation,
                      names.empty() ? path + " has no animation"
                                    : "there is no such animation; there are " +
                                          NearestFirst(options.animation, names));
  }
}

}  // namespace

std::string SceneEndings() {
  std::string text;
  for (const SceneFormat& format : kFormats) {
    text += (text.empty() ? "" : &format == std::end(kFormats) - 1 ? " or " : ", ");
    text += format.ending;
  }
  return text;
}

Scene ReadScene(const std::string& path, const ReadOptions& options) {
  std::error_code ignored;
  const bool is_file = std::filesystem::exists(path, ignored);
  Scene scene = is_file ? ReadByEnding(path, options) : BuiltinScene(path);
  if (!is_file) ResolveInstances(options, path, scene);
  CheckAnimation(path, options, scene);
  return scene;
}

}  // namespace skywave
