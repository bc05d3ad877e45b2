#include "scene/reader.h"

#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <utility>

#include "base/error.h"
#include "scene/builtin.h"
#include "scene/gltf_reader.h"
#include "scene/obj_reader.h"
#include "scene/pbrt_reader.h"
#include "scene/ply.h"

namespace skywave {
namespace {

std::string LowerCaseEnding(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
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

Scene ReadScene(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return BuiltinScene(path);
  const std::string ending = LowerCaseEnding(path);
  if (ending == ".pbrt") return ReadPbrt(path);
  if (ending == ".ply") return SceneOfOneMesh(ReadPly(path), path);
  if (ending == ".obj") return ReadObj(path);
  if (ending == ".gltf" || ending == ".glb") return ReadGltf(path);
  throw InputError(
      InputPosition::File(path),
      fmt::format("scenes end in .pbrt, .obj, .gltf, .glb or .ply, not in '{}'", ending));
}

}  // namespace skywave
