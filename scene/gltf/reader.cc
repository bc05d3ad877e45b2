#include "scene/gltf/reader.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
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
#include "scene/gltf/document.h"
#include "scene/gltf/instances.h"
#include "scene/gltf/lights.h"
#include "scene/gltf/materials.h"
#include "scene/gltf/meshes.h"
#include "scene/gltf/names.h"
#include "scene/instances.h"
#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

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

// Returns scene from node for all nodes, whose world has its `origin` at (0, 0, 0) of the scene.
// Those that are their own ancestors get any transform.
std::vector<glm::dmat4> WorldTransforms(const tinygltf::Model& model,
                                        const std::vector<GltfPose>& poses,
                                        const glm::dvec3& origin) {
  const std::size_t count = model.nodes.size();
  std::vector<glm::dmat4> worlds(count);
  std::vector<bool> is_child(count), done(count);
  std::vector<int> open;
  for (std::size_t i = 0; i < count; ++i) worlds[i] = LocalTransform(model.nodes[i], poses[i]);
  for (const tinygltf::Node& node : model.nodes) {
    for (const int child : node.children) {
      if (child >= 0 && std::size_t(child) < count) is_child[std::size_t(child)] = true;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_child[i]) open.push_back(int(i));
  }
  while (!open.empty()) {
    const auto parent = std::size_t(open.back());
    open.pop_back();
    for (const int child : model.nodes[parent].children) {
      if (child < 0 || std::size_t(child) >= count || done[std::size_t(child)]) continue;
      done[std::size_t(child)] = true;
      worlds[std::size_t(child)] = worlds[parent] * worlds[std::size_t(child)];
      open.push_back(child);
    }
  }
  for (glm::dmat4& world : worlds) world[3] -= glm::dvec4(origin, 0);
  return worlds;
}

// Returns the names of the scenes, which are their numbers where they have none.
std::vector<std::string> SceneNames(const tinygltf::Model& model) {
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model.scenes.size(); ++i) {
    names.push_back(NameOnce(model.scenes[i].name, i, taken));
  }
  return names;
}

// Returns the roots of the scene of that name or number; the name may be empty.
std::vector<int> Roots(const tinygltf::Model& model, const std::string& name,
                       const std::string& path) {
  if (!model.scenes.empty()) {
    int scene = std::max(model.defaultScene, 0);
    const std::vector<std::string> names = SceneNames(model);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (name == names[i] || (!name.empty() && name == std::to_string(i))) scene = int(i);
    }
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

// glTF's cameras look along -z; the scales of their nodes do not count. Their yfov is the vertical
// angle, of a view of their aspect that is seen whole on any film. Returns nothing for a camera
// without usable numbers.
std::optional<Camera> MakeCamera(const tinygltf::Camera& from, const glm::dmat4& world) {
  Camera camera;
  camera.square_pixels = true;
  const glm::dmat3 linear(world);
  if (!(std::abs(glm::determinant(linear)) > 0)) return std::nullopt;
  camera.world_from_camera = glm::mat4(
      glm::dmat4(glm::dvec4(glm::normalize(linear[0]), 0), glm::dvec4(glm::normalize(linear[1]), 0),
                 glm::dvec4(-glm::normalize(linear[2]), 0), world[3]));
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
  if (!(from.perspective.yfov > 0 && from.perspective.yfov < 3.14159)) return std::nullopt;
  camera.fov_degrees = float(glm::degrees(from.perspective.yfov));
  // Without an aspect the height of the film is that of the view, whatever its width.
  const double aspect = from.perspective.aspectRatio;
  const float side = aspect > 0 && aspect < 1e6 ? float(aspect) : 0.0f;
  camera.window = ScreenWindow{.left = -side, .right = side};
  return camera;
}

// Gives the film the aspect of a camera's view. Its longer side is that of films without settings.
void SetFilmOf(const Camera& camera, Scene& scene) {
  const ScreenWindow& view = *camera.window;
  const double aspect = double(view.right - view.left) / double(view.top - view.bottom);
  constexpr double kMost = 100, kLongerSide = 640;
  if (!(aspect > 1 / kMost && aspect < kMost)) return;
  scene.settings.width = int(std::lround(kLongerSide * std::min(aspect, 1.0)));
  scene.settings.height = int(std::lround(kLongerSide / std::max(aspect, 1.0)));
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
  if (!scene.camera) {
    scene.camera = camera;
    SetFilmOf(*camera, scene);
  }
  scene.cameras.push_back(
      {NameOnce(node.name.empty() ? from.name : node.name, index, names), *camera});
}

// Adds the meshes of nodes to a scene. One that stands in it more than once becomes an object with
// instances.
class MeshAdder {
 public:
  MeshAdder(const tinygltf::Model& model, const std::vector<GltfPose>& poses,
            GltfMaterials& materials, const std::string& path, const ReadOptions& options,
            Scene& scene, Warnings& warnings)
      : model_(model),
        poses_(poses),
        worlds_(WorldTransforms(model, poses, options.origin)),
        materials_(materials),
        path_(path),
        options_(options),
        scene_(scene),
        warnings_(warnings) {
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      const tinygltf::Node& node = model.nodes[i];
      if (node.mesh < 0 || std::size_t(node.mesh) >= model.meshes.size()) continue;
      places_[ShapeOf(i)] += HasGltfInstances(node) ? 2 : 1;
    }
  }

  const glm::dmat4& world(std::size_t node) const { return worlds_[node]; }

  // Adds the mesh of a node. One with a skin is where its joints are, not where the node is.
  void Add(std::size_t index) {
    const tinygltf::Node& node = model_.nodes[index];
    const glm::dmat4& world = worlds_[index];
    const Shape shape = ShapeOf(index);
    if (node.skin >= 0) {
      const GltfSkin skin = MakeGltfSkin(model_, node.skin, worlds_, path_);
      for (Mesh& mesh : Read(shape, &skin)) {
        mesh.node = node.name;
        scene_.meshes.push_back(std::move(mesh));
      }
      return;
    }
    if (places_[shape] < 2) {
      for (Mesh& mesh : Read(shape)) {
        TransformMesh(world, mesh);
        mesh.node = node.name;
        scene_.meshes.push_back(std::move(mesh));
      }
      return;
    }
    const auto [object, is_new] = objects_.try_emplace(shape, std::uint32_t(scene_.objects.size()));
    if (is_new) {
      scene_.objects.push_back({.name = model_.meshes[std::size_t(node.mesh)].name, .meshes = {}});
      scene_.objects.back().meshes = Read(shape);
    }
    std::uint32_t number = kNoNode;
    if (!node.name.empty()) {
      number = std::uint32_t(scene_.nodes.size());
      scene_.nodes.push_back(node.name);
    }
    for (const glm::dmat4& local : GltfInstances(model_, node, path_)) {
      scene_.instances.push_back({.object = object->second,
                                  .world_from_object = glm::dmat4x3(world * local),
                                  .meshes_before = std::uint32_t(scene_.meshes.size()),
                                  .node = number});
    }
    if (scene_.instances.size() > kMaxInstances) {
      FailGltf(path_, fmt::format("has more than {} instances", kMaxInstances));
    }
  }

 private:
  // A mesh, and the weights of its morph targets.
  using Shape = std::pair<int, std::vector<double>>;

  // Animated weights are taken before those of a node, and these before those of its mesh.
  Shape ShapeOf(std::size_t index) const {
    const tinygltf::Node& node = model_.nodes[index];
    if (poses_[index].weights) return {node.mesh, *poses_[index].weights};
    if (std::size_t(node.mesh) >= model_.meshes.size() || !node.weights.empty()) {
      return {node.mesh, node.weights};
    }
    return {node.mesh, model_.meshes[std::size_t(node.mesh)].weights};
  }

  std::vector<Mesh> Read(const Shape& shape, const GltfSkin* skin = nullptr) {
    std::vector<Mesh> meshes = MakeGltfMeshes(model_, shape.first, shape.second, skin, options_,
                                              materials_, path_, warnings_);
    for (const Mesh& mesh : meshes) triangles_ += mesh.triangles.size();
    if (triangles_ > options_.max_triangles) {
      FailGltf(path_,
               fmt::format("has more than {} triangles (`max-triangles`)", options_.max_triangles));
    }
    return meshes;
  }

  const tinygltf::Model& model_;
  const std::vector<GltfPose>& poses_;
  const std::vector<glm::dmat4> worlds_;
  GltfMaterials& materials_;
  const std::string& path_;
  const ReadOptions& options_;
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
void AddNodes(const tinygltf::Model& model, const std::vector<int>& roots, const std::string& path,
              MeshAdder& adder, Scene& scene, Warnings& warnings) {
  struct Visit {
    int node;
    bool hidden = false;
  };
  std::vector<Visit> open;
  for (const int root : roots) open.push_back({root, false});
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
    const auto index = std::size_t(visit.node);
    const tinygltf::Node& node = model.nodes[index];
    const glm::dmat4& world = adder.world(index);
    const bool hidden = visit.hidden || IsHidden(node);
    if (node.mesh >= 0 && !hidden) adder.Add(index);
    if (!hidden) AddGltfLight(model, node, world, path, scene, warnings);
    if (node.camera >= 0) {
      AddCamera(model, index, world, path, camera_names, scene, warnings);
    }
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
      open.push_back({*child, hidden});
    }
  }
}

// Returns the primitives that AddNodes will make meshes of, as far as the file is right.
std::vector<const tinygltf::Primitive*> VisiblePrimitives(const tinygltf::Model& model,
                                                          const std::vector<int>& roots,
                                                          const ReadOptions& options) {
  std::vector<const tinygltf::Primitive*> primitives;
  std::vector<int> open = roots;
  std::vector<bool> seen(model.nodes.size());
  while (!open.empty()) {
    const auto index = std::size_t(open.back());
    open.pop_back();
    if (index >= seen.size() || seen[index] || IsHidden(model.nodes[index])) continue;
    seen[index] = true;
    const tinygltf::Node& node = model.nodes[index];
    open.insert(open.end(), node.children.begin(), node.children.end());
    if (node.mesh < 0 || std::size_t(node.mesh) >= model.meshes.size()) continue;
    for (const tinygltf::Primitive& primitive : model.meshes[std::size_t(node.mesh)].primitives) {
      if (WhyLeftOut(model, node.mesh, primitive, options).empty())
        primitives.push_back(&primitive);
    }
  }
  return primitives;
}

void DropVertexColors(Scene& scene) {
  const auto drop = [](std::vector<Mesh>& meshes) {
    for (Mesh& mesh : meshes) mesh.colors.clear(), mesh.alphas.clear();
  };
  drop(scene.meshes);
  for (Object& object : scene.objects) drop(object.meshes);
}

// Returns the bounds of the triangles at frame 0.
Bounds BoundsAtFirstFrame(const tinygltf::Model& model, ReadOptions options,
                          const std::string& path, GltfMaterials& materials) {
  options.frame = 0;
  options.strict = false;  // the scene itself says what is left out
  Scene first;
  Warnings unused = MakeWarnings(options);
  const std::vector<GltfPose> poses = PoseGltfNodes(model, options, path, unused);
  MeshAdder adder(model, poses, materials, path, options, first, unused);
  AddNodes(model, Roots(model, options.scene, path), path, adder, first, unused);
  return TriangleBounds(first);
}

}  // namespace

Scene ParseGltf(const std::string& bytes, const std::string& path, const ReadOptions& options) {
  Scene scene;
  Warnings warnings = MakeWarnings(options);
  const tinygltf::Model model = LoadGltf(bytes, path, warnings);
  GltfMaterials materials(model, path, scene, warnings);
  scene.scenes = SceneNames(model);
  scene.variants = GltfVariants(model);
  const auto variant = std::find(scene.variants.begin(), scene.variants.end(), options.variant);
  if (variant != scene.variants.end()) {
    materials.ChooseVariant(int(variant - scene.variants.begin()));
  }
  const std::vector<int> roots = Roots(model, options.scene, path);
  materials.DecodeImagesOf(VisiblePrimitives(model, roots, options));
  const std::vector<GltfPose> poses = PoseGltfNodes(model, options, path, warnings);
  MeshAdder adder(model, poses, materials, path, options, scene, warnings);
  AddNodes(model, roots, path, adder, scene, warnings);
  if (options.vertex_colors == VertexColors::kOff) DropVertexColors(scene);
  ResolveInstances(options, path, scene);
  scene.animations = ListGltfAnimations(model, path, warnings);
  if (!scene.animations.empty() && options.frame.value_or(0) != 0) {
    const Bounds first = BoundsAtFirstFrame(model, options, path, materials);
    if (!IsEmpty(first)) scene.first_bounds = first;
  }
  if (!scene.animations.empty() && !options.frame) {
    AddNote(warnings, InputPosition::File(path),
            "is animated, and no frame is asked for: everything is left at rest");
  }
  SetRemarks(warnings, scene);
  return scene;
}

Scene ReadGltf(const std::string& path, const ReadOptions& options) {
  return ParseGltf(ReadFile(path, std::size_t{2} << 30), path, options);
}

}  // namespace skywave
