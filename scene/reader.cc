#include "scene/reader.h"

#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <utility>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "scene/gltf/reader.h"
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

Scene SceneOfOneMesh(Mesh mesh, const std::string& path) {
  Scene scene;
  mesh.name = path;
  scene.materials.push_back({.name = "default"});
  scene.meshes.push_back(std::move(mesh));
  return scene;
}

}  // namespace

Scene ReadScene(const std::string& path, const ReadOptions& options) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return BuiltinScene(path);
  const std::string ending = LowerCaseEnding(path);
  if (ending == ".pbrt") return ReadPbrt(path, options);
  if (ending == ".ply") return SceneOfOneMesh(ReadPly(path), path);
  if (ending == ".obj") return ReadObj(path, options);
  if (ending == ".gltf" || ending == ".glb") return ReadGltf(path, options);
  throw InputError(
      InputPosition::File(path),
      fmt::format("scenes end in .pbrt, .obj, .gltf, .glb or .ply, not in '{}'", ending));
}

}  // namespace skywave
