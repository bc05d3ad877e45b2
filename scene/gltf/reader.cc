#include "scene/gltf/reader.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "scene/gltf/animation.h"
#include "scene/gltf/buffers.h"
#include "scene/gltf/instances.h"
#include "scene/gltf/lights.h"
#include "scene/gltf/materials.h"
#include "scene/gltf/meshes.h"
#include "scene/gltf/names.h"
#include "scene/instances.h"
#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

namespace fs = std::filesystem;

// Files are only read from below the glTF file's folder.
struct Folder {
  fs::path path;
  std::string refused;  // the first name outside the folder
};

// Returns the file of that name, or nothing. tinygltf may prefix names with "./".
std::optional<fs::path> Inside(Folder& folder, const std::string& name) {
  // tinygltf takes data of types that it does not know, such as WebP, for names of files.
  if (name.starts_with("data:") || name.starts_with("./data:")) return std::nullopt;
  const fs::path relative(name);
  const bool leaves = relative.is_absolute() || name.find('\\') != std::string::npos ||
                      name.find(':') != std::string::npos ||
                      std::find(relative.begin(), relative.end(), "..") != relative.end() ||
                      name.starts_with(".//");
  if (leaves) {
    if (folder.refused.empty()) folder.refused = name;
    return std::nullopt;
  }
  return folder.path / relative;
}

bool Exists(const std::string& name, void* user) {
  const auto path = Inside(*static_cast<Folder*>(user), name);
  std::error_code ignored;
  return path && fs::is_regular_file(*path, ignored);
}
// The default function passes names through shell expansion.
std::string KeepPath(const std::string& name, void*) { return name; }
bool ReadWhole(std::vector<unsigned char>* out, std::string* error, const std::string& name,
               void* user) {
  const auto path = Inside(*static_cast<Folder*>(user), name);
  if (!path) return false;
  try {
    const std::string bytes = ReadFile(path->string(), std::size_t{2} << 30);
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
Callbacks FilesOf(Folder& folder) {
  Callbacks callbacks = {};
  callbacks.FileExists = Exists;
  callbacks.ExpandFilePath = KeepPath;
  callbacks.ReadWholeFile = ReadWhole;
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&,
                                void*) { return false; };
  if constexpr (requires { callbacks.GetFileSizeInBytes; }) {
    callbacks.GetFileSizeInBytes = [](std::size_t* size, std::string*, const std::string& name,
                                      void* user) {
      const auto path = Inside(*static_cast<Folder*>(user), name);
      std::error_code error;
      *size = path ? fs::file_size(*path, error) : 0;
      return path && !error;
    };
  }
  callbacks.user_data = &folder;
  return callbacks;
}

// Images stay encoded as in the file. Those in buffer views are looked up only once their range has
// been checked, because tinygltf has not checked it.
bool KeepImage(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
               const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

tinygltf::Model Load(const std::string& bytes, const std::string& path) {
  Folder folder{fs::path(path).parent_path(), ""};
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(FilesOf<tinygltf::FsCallbacks>(folder));
  loader.SetImageLoader(KeepImage, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  bool loaded = false;
  try {
    const auto size = static_cast<unsigned int>(bytes.size());
    loaded = bytes.starts_with("glTF")
                 ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                               reinterpret_cast<const unsigned char*>(bytes.data()),
                                               size, "")
                 : loader.LoadASCIIFromString(&model, &error, &warning, bytes.c_str(), size, "");
  } catch (const std::exception& reason) {
    // The JSON parser of tinygltf throws this on unexpected types.
    error = reason.what();
  }
  if (!folder.refused.empty()) {
    FailGltf(path, fmt::format("names \"{}\", which is not below its folder", folder.refused));
  }
  // An extension that is missing here may be why the file was not understood, so it comes first.
  for (const std::string& extension : model.extensionsRequired) {
    static const char* const kKnown[] = {
        "KHR_texture_transform", "KHR_materials_ior",      "KHR_materials_transmission",
        "KHR_materials_unlit",   "KHR_mesh_quantization",  "KHR_materials_emissive_strength",
        "KHR_lights_punctual",   "KHR_materials_specular", "KHR_materials_clearcoat",
        "KHR_materials_sheen",   "KHR_materials_volume",   "EXT_mesh_gpu_instancing",
        "KHR_node_visibility"};
    if (std::find(std::begin(kKnown), std::end(kKnown), extension) == std::end(kKnown)) {
      FailGltf(path, fmt::format("needs the extension {}, which is not supported", extension));
    }
  }
  if (!loaded) {
    std::replace(error.begin(), error.end(), '\n', ' ');
    FailGltf(path, "is no glTF file to read: " + error.substr(0, 300));
  }
  return model;
}

// Returns T * R * S, with the values of `pose` instead of the file's where it has them.
glm::dmat4 LocalTransform(const tinygltf::Node& node, const GltfPose& pose) {
  if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
  glm::dmat4 matrix(1);
  if (pose.rotation) {
    matrix = glm::mat4_cast(*pose.rotation);
  } else if (node.rotation.size() == 4) {
    const auto& r = node.rotation;
    matrix = glm::mat4_cast(glm::normalize(glm::dquat(r[3], r[0], r[1], r[2])));
  }
  for (int c = 0; c < 3; ++c) {
    if (pose.scale) {
      matrix[c] *= (*pose.scale)[c];
    } else if (node.scale.size() == 3) {
      matrix[c] *= node.scale[std::size_t(c)];
    }
    if (pose.translation) {
      matrix[3][c] = (*pose.translation)[c];
    } else if (node.translation.size() == 3) {
      matrix[3][c] = node.translation[std::size_t(c)];
    }
  }
  return matrix;
}

// Returns the roots of the default scene.
std::vector<int> Roots(const tinygltf::Model& model, const std::string& path) {
  if (!model.scenes.empty()) {
    const int scene = std::max(model.defaultScene, 0);
    if (std::size_t(scene) >= model.scenes.size()) {
      FailGltf(path, fmt::format("there is no scene {}", scene));
    }
    return model.scenes[std::size_t(scene)].nodes;
  }
  std::vector<bool> is_child(model.nodes.size());
  for (const tinygltf::Node& node : model.nodes) {
    for (const int child : node.children) {
      if (child >= 0 && std::size_t(child) < is_child.size()) is_child[std::size_t(child)] = true;
    }
  }
  std::vector<int> roots;
  for (std::size_t i = 0; i < is_child.size(); ++i) {
    if (!is_child[i]) roots.push_back(int(i));
  }
  return roots;
}

// glTF's cameras look along -z. Their yfov is the vertical angle; Camera's angle is that of the
// shorter side. Returns nothing for a camera without usable numbers.
std::optional<Camera> MakeCamera(const tinygltf::Camera& from, const glm::dmat4& world) {
  Camera camera;
  camera.world_from_camera =
      glm::mat4(world * glm::dmat4(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 1, 0, 0),
                                   glm::dvec4(0, 0, -1, 0), glm::dvec4(0, 0, 0, 1)));
  if (!(std::abs(glm::determinant(glm::mat3(camera.world_from_camera))) > 0)) return std::nullopt;
  if (from.type == "orthographic") {
    const double x = from.orthographic.xmag, y = from.orthographic.ymag;
    const bool usable =
        std::abs(x) > 0 && std::abs(y) > 0 && std::abs(x) < 1e18 && std::abs(y) < 1e18;
    if (!usable) return std::nullopt;
    camera.kind = CameraKind::kOrthographic;
    camera.window = ScreenWindow{-float(std::abs(x)), float(std::abs(x)), -float(std::abs(y)),
                                 float(std::abs(y))};
    return camera;
  }
  double slope = std::tan(0.5 * from.perspective.yfov);
  if (!(from.perspective.yfov > 0 && from.perspective.yfov < 3.14159)) return std::nullopt;
  const double aspect = from.perspective.aspectRatio;
  if (aspect > 0 && aspect < 1) slope *= aspect;
  camera.fov_degrees = float(2 * glm::degrees(std::atan(slope)));
  return camera;
}

// Adds the camera of node `index`. The first one of a file is rendered unless another is asked for,
// so it has to be usable; the others may be left out.
void AddCamera(const tinygltf::Model& model, std::size_t index, const glm::dmat4& world,
               const std::string& path, std::set<std::string>& names, Scene& scene,
               Warnings& warnings) {
  const tinygltf::Node& node = model.nodes[index];
  if (std::size_t(node.camera) >= model.cameras.size()) {
    FailGltf(path, fmt::format("there is no camera {}", node.camera));
  }
  const tinygltf::Camera& from = model.cameras[std::size_t(node.camera)];
  const std::optional<Camera> camera = MakeCamera(from, world);
  const std::string problem = fmt::format("camera '{}' has no usable numbers", from.name);
  if (!camera && scene.cameras.empty()) FailGltf(path, problem);
  if (!camera) {
    AddNote(warnings, InputPosition::File(path), problem + ": left out");
    return;
  }
  if (!scene.camera) scene.camera = camera;
  scene.cameras.push_back(
      {NameOnce(node.name.empty() ? from.name : node.name, index, names), *camera});
}

// Adds the meshes of nodes to a scene. One that stands in it more than once becomes an object with
// instances.
class MeshAdder {
 public:
  MeshAdder(const tinygltf::Model& model, const GltfMaterials& materials, const std::string& path,
            std::size_t max_triangles, Scene& scene, Warnings& warnings)
      : model_(model),
        materials_(materials),
        path_(path),
        max_triangles_(max_triangles),
        scene_(scene),
        warnings_(warnings) {
    for (const tinygltf::Node& node : model.nodes) {
      if (node.mesh < 0 || std::size_t(node.mesh) >= model.meshes.size()) continue;
      places_[ShapeOf(node)] += HasGltfInstances(node) ? 2 : 1;
    }
  }

  void Add(const tinygltf::Node& node, const glm::dmat4& world) {
    const Shape shape = ShapeOf(node);
    if (places_[shape] < 2) {
      for (Mesh& mesh : Read(shape)) {
        TransformMesh(world, mesh);
        scene_.meshes.push_back(std::move(mesh));
      }
      return;
    }
    const auto [object, is_new] = objects_.try_emplace(shape, std::uint32_t(scene_.objects.size()));
    if (is_new) {
      scene_.objects.push_back({.name = model_.meshes[std::size_t(node.mesh)].name, .meshes = {}});
      scene_.objects.back().meshes = Read(shape);
    }
    for (const glm::dmat4& local : GltfInstances(model_, node, path_)) {
      scene_.instances.push_back({.object = object->second,
                                  .world_from_object = glm::dmat4x3(world * local),
                                  .meshes_before = std::uint32_t(scene_.meshes.size())});
    }
    if (scene_.instances.size() > kMaxInstances) {
      FailGltf(path_, fmt::format("has more than {} instances", kMaxInstances));
    }
  }

 private:
  // A mesh, and the weights of its morph targets.
  using Shape = std::pair<int, std::vector<double>>;

  // Weights of a node are taken before those of its mesh.
  Shape ShapeOf(const tinygltf::Node& node) const {
    if (std::size_t(node.mesh) >= model_.meshes.size() || !node.weights.empty()) {
      return {node.mesh, node.weights};
    }
    return {node.mesh, model_.meshes[std::size_t(node.mesh)].weights};
  }

  std::vector<Mesh> Read(const Shape& shape) {
    std::vector<Mesh> meshes =
        MakeGltfMeshes(model_, shape.first, shape.second, materials_, path_, warnings_);
    for (const Mesh& mesh : meshes) triangles_ += mesh.triangles.size();
    if (triangles_ > max_triangles_) {
      FailGltf(path_, fmt::format("has more than {} triangles (`max-triangles`)", max_triangles_));
    }
    return meshes;
  }

  const tinygltf::Model& model_;
  const GltfMaterials& materials_;
  const std::string& path_;
  std::size_t max_triangles_;
  Scene& scene_;
  Warnings& warnings_;
  std::map<Shape, std::size_t> places_;  // how often it stands in the scene, at least
  std::map<Shape, std::uint32_t> objects_;
  std::size_t triangles_ = 0;
};

// Returns whether KHR_node_visibility hides the node and all below it.
bool IsHidden(const tinygltf::Node& node) {
  const auto found = node.extensions.find("KHR_node_visibility");
  if (found == node.extensions.end() || !found->second.IsObject()) return false;
  if (!found->second.Has("visible")) return false;
  const tinygltf::Value& visible = found->second.Get("visible");
  return visible.IsBool() && !visible.Get<bool>();
}

// Walks the trees below the roots; every node has at most one parent.
void AddNodes(const tinygltf::Model& model, const std::vector<GltfPose>& poses,
              const std::string& path, MeshAdder& adder, Scene& scene, Warnings& warnings) {
  struct Visit {
    int node;
    glm::dmat4 parent;
    bool hidden = false;
  };
  std::vector<Visit> open;
  for (const int root : Roots(model, path)) open.push_back({root, glm::dmat4(1), false});
  std::reverse(open.begin(), open.end());
  std::vector<bool> seen(model.nodes.size());
  std::set<std::string> camera_names;
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    if (visit.node < 0 || std::size_t(visit.node) >= model.nodes.size()) {
      FailGltf(path, fmt::format("there is no node {}", visit.node));
    }
    if (seen[std::size_t(visit.node)]) {
      FailGltf(path, fmt::format("node {} has two parents or is its own ancestor", visit.node));
    }
    seen[std::size_t(visit.node)] = true;
    const tinygltf::Node& node = model.nodes[std::size_t(visit.node)];
    const glm::dmat4 world = visit.parent * LocalTransform(node, poses[std::size_t(visit.node)]);
    const bool hidden = visit.hidden || IsHidden(node);
    if (node.skin >= 0 && !hidden) {
      AddWarning(warnings, InputPosition::File(path), "skins are not supported: left at rest");
    }
    if (node.mesh >= 0 && !hidden) adder.Add(node, world);
    if (!hidden) AddGltfLight(model, node, world, path, scene, warnings);
    if (node.camera >= 0) {
      AddCamera(model, std::size_t(visit.node), world, path, camera_names, scene, warnings);
    }
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
      open.push_back({*child, world, hidden});
    }
  }
}

}  // namespace

Scene ParseGltf(const std::string& bytes, const std::string& path, const ReadOptions& options) {
  const tinygltf::Model model = Load(bytes, path);
  Scene scene;
  Warnings warnings{.entries = {}, .by_text = {}, .strict = options.strict};
  const GltfMaterials materials = AddGltfMaterials(model, path, scene, warnings);
  const std::vector<GltfPose> poses = PoseGltfNodes(model, options, path, warnings);
  MeshAdder adder(model, materials, path, options.max_triangles, scene, warnings);
  AddNodes(model, poses, path, adder, scene, warnings);
  ResolveInstances(options, path, scene);
  scene.animations = ListGltfAnimations(model, path, warnings);
  if (!scene.animations.empty() && !options.frame) {
    AddNote(warnings, InputPosition::File(path),
            "is animated, and no frame is asked for: everything is left at rest");
  }
  scene.warnings = WarningLines(warnings);
  return scene;
}

Scene ReadGltf(const std::string& path, const ReadOptions& options) {
  return ParseGltf(ReadFile(path, std::size_t{2} << 30), path, options);
}

}  // namespace skywave
