#include "scene/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/nearest_name.h"
#include "scene/builtin/builtin.h"
#include "scene/gltf/reader.h"
#include "scene/instances.h"
#include "scene/materials/texture_files.h"
#include "scene/named_files.h"
#include "scene/obj/reader.h"
#include "scene/pbrt/reader.h"
#include "scene/shapes/ply.h"
#include "scene/shapes/points.h"
#include "scene/warnings.h"

namespace skywave {
namespace {

std::string LowerCaseEnding(std::filesystem::path path) {
  if (path.extension() == ".gz") path.replace_extension();
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

Scene ReadPlyScene(const std::string& path, const ReadOptions& options) {
  PlyReport report;
  Mesh mesh = ReadPlyPoints(path, &report, options.origin);
  if (mesh.triangles.empty() && !options.point_size) {
    throw InputError(
        InputPosition::File(path),
        fmt::format("has {} vertices and no faces: `point-size {:g}` shows them as spheres",
                    mesh.positions.size(), PointSizeFor(mesh.positions)));
  }
  if (mesh.triangles.empty()) {
    mesh = MakePoints(mesh, AllPoints(mesh), *options.point_size, options.max_triangles, path);
  }
  Warnings warnings = MakeWarnings(options);
  const auto position = InputPosition::File(path);
  WarnOfPly(report, position, warnings);
  mesh.name = path;
  Scene scene;
  Material material = {.name = "default"};
  if (options.vertex_colors == VertexColors::kOff) mesh.colors.clear();
  // Colours and a texture are those of the surface, and not of the grey that stands for neither.
  if (!mesh.colors.empty()) material.reflectance = glm::vec3(1);
  if (!report.texture.empty() && !mesh.uvs.empty()) {
    TextureFiles textures{&scene};
    const auto file = FindNamedOrMovedFile(position, report.texture, warnings);
    try {
      if (!file) throw InputError::NoSuchFile(position, report.texture);
      scene.textures.push_back({.image = AddTextureImage(textures, *file, Encoding::kSrgb),
                                .transform = UpwardTextureTransform({1, 1}, {0, 0})});
      material.color_texture = 0;
      material.reflectance = glm::vec3(1);
    } catch (const InputError& error) {
      AddMissing(warnings, position, "TextureFile", error, "left out");
    }
  }
  scene.materials.push_back(std::move(material));
  scene.meshes.push_back(std::move(mesh));
  SetRemarks(warnings, scene);
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

// Returns the middle of a scene that is so far from (0, 0, 0) that the places of floats are seen:
// at a hundred times its size they are 6 * 10^-6 of it apart.
std::optional<glm::dvec3> FarMiddle(const Scene& scene) {
  constexpr double kFar = 100;
  const Bounds bounds = scene.first_bounds.value_or(TriangleBounds(scene));
  if (IsEmpty(bounds)) return std::nullopt;
  const glm::dvec3 low(bounds.low), high(bounds.high), middle = 0.5 * (low + high);
  const double distance = glm::length(middle);
  if (!std::isfinite(distance) || distance <= kFar * glm::length(high - low)) return std::nullopt;
  return middle;
}

// A scene that turns out to be far away is read again, about its middle.
Scene ReadAboutItsMiddle(const SceneFormat& format, const std::string& path, ReadOptions options) {
  Scene scene = format.read(path, options);
  if (const auto middle = FarMiddle(scene)) {
    options.origin = *middle;
    scene = {};
    scene = format.read(path, options);
    scene.origin = *middle;
  }
  return scene;
}

Scene ReadByEnding(const std::string& path, const ReadOptions& options) {
  const std::string ending = LowerCaseEnding(path);
  for (const SceneFormat& format : kFormats) {
    if (format.ending == ending) return ReadAboutItsMiddle(format, path, options);
  }
  throw InputError(InputPosition::File(path),
                   fmt::format("scenes end in {}, not in '{}'", SceneEndings(), ending));
}

// Throws OptionError unless `wanted`, the value of an option, is empty or one of `names`.
void CheckName(const std::string& path, const char* option, const std::string& thing,
               const std::string& wanted, const std::vector<std::string_view>& names) {
  if (wanted.empty() || std::find(names.begin(), names.end(), wanted) != names.end()) return;
  throw OptionError(
      option, wanted,
      names.empty() ? path + " has no " + thing
                    : "there is no such " + thing + "; there are " + NearestFirst(wanted, names));
}

// Checks what `options` ask of a scene by name, whatever its format.
void CheckNames(const std::string& path, const ReadOptions& options, const Scene& scene) {
  std::vector<std::string_view> animations;
  for (const AnimationInfo& animation : scene.animations) animations.push_back(animation.name);
  CheckName(path, "animation", "animation", options.animation, animations);
  CheckName(path, "variant", "variant", options.variant,
            {scene.variants.begin(), scene.variants.end()});
  std::vector<std::string> places;
  for (std::size_t i = 0; i < scene.scenes.size(); ++i) places.push_back(std::to_string(i));
  if (std::find(places.begin(), places.end(), options.scene) != places.end()) return;
  CheckName(path, "gltf-scene", "choice of scenes", options.scene,
            {scene.scenes.begin(), scene.scenes.end()});
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
  CheckNames(path, options, scene);
  return scene;
}

}  // namespace skywave
