// Implements Scene: arrays are checked and become the plain data that readers produce too.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "api/errors.h"
#include "api/state.h"
#include "base/clock.h"
#include "base/error.h"
#include "job/camera_file.h"
#include "job/options.h"
#include "scene/geometry_checks.h"
#include "scene/instances.h"
#include "scene/materials/parameters.h"
#include "scene/reader.h"
#include "scene/scene_hash.h"
#include "scene/shapes/points.h"

namespace skywave::api {
namespace {

constexpr std::size_t kMostTexels = std::size_t{1} << 30;

glm::vec3 Vec3(const Vector& v) { return {v[0], v[1], v[2]}; }

void RequireFinite(std::span<const float> values, const std::string& name) {
  const auto bad =
      std::find_if(values.begin(), values.end(), [](float x) { return !std::isfinite(x); });
  if (bad == values.end()) return;
  throw Error(Error::Kind::kUsage, name, fmt::format("value {} is {}", bad - values.begin(), *bad));
}

void RequireNotNegative(std::span<const float> values, const std::string& name) {
  RequireFinite(values, name);
  Require(std::all_of(values.begin(), values.end(), [](float x) { return x >= 0; }), name,
          "must not be negative");
}

glm::vec3 Direction(const Vector& v, const std::string& name) {
  RequireFinite(v, name);
  const float length = glm::length(Vec3(v));
  Require(length > 0 && std::isfinite(length), name, "has no direction");
  return Vec3(v) / length;
}

glm::vec3 Emission(const Vector& v, const std::string& name) {
  RequireNotNegative(v, name);
  return Vec3(v);
}

// Returns `values` as rows, of which there must be `rows` or none.
template <class Row>
std::vector<Row> Rows(std::span<const float> values, std::size_t rows, const std::string& name) {
  constexpr std::size_t kColumns = sizeof(Row) / sizeof(float);
  if (values.empty()) return {};
  Require(
      values.size() == rows * kColumns, name,
      fmt::format("has {} values, and {} vertices need {}", values.size(), rows, rows * kColumns));
  RequireFinite(values, name);
  std::vector<Row> result(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < kColumns; ++column) {
      result[row][int(column)] = values[row * kColumns + column];
    }
  }
  return result;
}

std::vector<glm::vec3> UnitNormals(std::span<const float> values, std::size_t vertices) {
  std::vector<glm::vec3> normals = Rows<glm::vec3>(values, vertices, "normals");
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const float length = glm::length(normals[i]);
    Require(length > 0 && std::isfinite(length), "normals",
            fmt::format("the normal of vertex {} has length {}", i, length));
    normals[i] /= length;
  }
  return normals;
}

std::vector<glm::uvec3> Triangles(std::span<const std::uint32_t> indices, std::size_t vertices) {
  Require(!indices.empty() && indices.size() % 3 == 0, "triangles",
          fmt::format("there are {} indices, and each triangle needs 3", indices.size()));
  std::vector<glm::uvec3> triangles(indices.size() / 3);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    Require(
        indices[i] < vertices, "triangles",
        fmt::format("triangle {} names vertex {}, and there are {}", i / 3, indices[i], vertices));
    triangles[i / 3][int(i % 3)] = indices[i];
  }
  return triangles;
}

std::vector<glm::uvec2> Lines(std::span<const std::uint32_t> indices, std::size_t points) {
  Require(indices.size() % 2 == 0, "lines",
          fmt::format("there are {} indices, and each line needs 2", indices.size()));
  std::vector<glm::uvec2> lines(indices.size() / 2);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    Require(indices[i] < points, "lines",
            fmt::format("line {} names point {}, and there are {}", i / 2, indices[i], points));
    lines[i / 2][int(i % 2)] = indices[i];
  }
  return lines;
}

// Returns the number of vertices with these coordinates.
std::size_t CountVertices(std::span<const float> positions) {
  Require(!positions.empty() && positions.size() % 3 == 0, "positions",
          fmt::format("there are {} values, and each vertex needs 3", positions.size()));
  const std::size_t vertices = positions.size() / 3;
  Require(
      vertices < kMaxRecords, "positions",
      fmt::format("there are {} vertices, and a mesh has fewer than {}", vertices, kMaxRecords));
  return vertices;
}

void RequireObject(const skywave::Scene& scene, int object) {
  Require(object >= 0 && std::size_t(object) < scene.objects.size(), "object",
          fmt::format("there is none with number {}; there are {}", object, scene.objects.size()));
}

// Checks what meshes and points have in common besides their places.
template <class Arrays>
void CheckLook(const Arrays& arrays, std::size_t vertices, const skywave::Scene& scene) {
  Require(arrays.material >= 0 && std::size_t(arrays.material) < scene.materials.size(), "material",
          fmt::format("there is none with number {}; there are {}", arrays.material,
                      scene.materials.size()));
  RequireNotNegative(arrays.colors, "colors");
  Require(arrays.alphas.empty() || arrays.alphas.size() == vertices, "alphas",
          fmt::format("there are {} values, and {} vertices need one each", arrays.alphas.size(),
                      vertices));
  Require(std::all_of(arrays.alphas.begin(), arrays.alphas.end(),
                      [](float alpha) { return alpha >= 0 && alpha <= 1; }),
          "alphas", "one of them is not in [0, 1]");
  if (arrays.object != -1) RequireObject(scene, arrays.object);
}

// Gives a mesh the name and the material of the arrays that it was made of, and a place in a scene.
template <class Arrays>
void AppendMesh(SceneState& state, const Arrays& arrays, Mesh mesh) {
  skywave::Scene& scene = state.Change();
  std::vector<Mesh>& meshes =
      arrays.object < 0 ? scene.meshes : scene.objects[std::size_t(arrays.object)].meshes;
  mesh.name = arrays.name.empty() ? fmt::format("mesh {}", meshes.size()) : arrays.name;
  mesh.material = std::uint32_t(arrays.material);
  if (arrays.object < 0) {
    for (glm::vec3& p : mesh.positions) p = PlaceInScene(scene, p);
  }
  meshes.push_back(std::move(mesh));
  state.changed = true;
}

}  // namespace

skywave::Image CopyImage(const ImageArray& image, const std::string& name) {
  const bool sized = image.width > 0 && image.height > 0 &&
                     std::size_t(image.width) <= kMostTexels / std::size_t(image.height);
  Require(sized, name, fmt::format("cannot be {} x {} pixels", image.width, image.height));
  const std::size_t floats = std::size_t(image.width) * std::size_t(image.height) * 3;
  Require(image.rgb.size() == floats, name,
          fmt::format("has {} values, and {} x {} pixels need {}", image.rgb.size(), image.width,
                      image.height, floats));
  skywave::Image copy;
  copy.width = image.width, copy.height = image.height;
  copy.rgb.assign(image.rgb.begin(), image.rgb.end());
  return copy;
}

skywave::Scene& SceneState::Change() {
  shared.reset();  // the cache lets go of the scene, unless a copy of this object shares it
  if (has_copies) loaded = std::make_shared<LoadedScene>(loaded->scene);
  has_copies = false;
  return loaded->scene;
}

std::unique_ptr<SceneState> SceneState::Copy() {
  has_copies = true;
  return std::make_unique<SceneState>(*this);
}

const SharedScene& SceneState::Share() const {
  if (shared) return *shared;
  if (changed && !(scene().instances.empty() && scene().objects.empty())) {
    auto resolved = std::make_shared<LoadedScene>(scene());
    ResolveInstances(read, name(), resolved->scene);
    shared = std::make_shared<SharedScene>(std::move(resolved));
  } else {
    shared = std::make_shared<SharedScene>(loaded);
  }
  return *shared;
}

Scene::Scene() : state_(std::make_unique<SceneState>()) {
  state_->Change().materials.push_back({.name = "grey"});
  state_->changed = true;
}

Scene::Scene(const std::string& path, const Options& options)
    : state_(std::make_unique<SceneState>()) {
  Translated([&] {
    const auto request = std::make_shared<JobRequest>();
    std::vector<BoundOption> bound;
    for (const JobOption& option : JobOptions()) {
      if (option.of_reading) bound.push_back(Bind(option, request));
    }
    SetOptions(bound, options);
    const Clock::time_point start = Clock::now();
    state_->loaded = std::make_shared<LoadedScene>(ReadScene(path, request->read));
    state_->source = path;
    state_->read = request->read;
    state_->load_seconds = SecondsSince(start);
  });
}

Scene::Scene(const Scene& other) : state_(other.state_->Copy()) {}
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(const Scene& other) {
  state_ = other.state_->Copy();
  return *this;
}
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

int Scene::AddTexture(const ImageArray& image, TextureUse use) {
  skywave::Image copy = CopyImage(image, "image");
  RequireFinite(copy.rgb, "image");
  // Both enums of that name have the same values in the same order.
  static_assert(int(TextureUse::kHeights) == int(skywave::TextureUse::kHeights));
  skywave::Scene& scene = state_->Change();
  const auto number = std::uint32_t(scene.images.size());
  // The image comes first: without its texture it is harmless if memory ends here.
  scene.images.push_back(std::move(copy));
  scene.textures.push_back({.image = number, .use = skywave::TextureUse(int(use))});
  state_->changed = true;
  return int(scene.textures.size()) - 1;
}

int Scene::AddMaterial(const std::string& bsdf, const std::vector<MaterialParameter>& parameters,
                       const std::string& name) {
  skywave::Scene& scene = state_->Change();
  Material material = Translated([&] {
    Material made = MakeMaterial(bsdf);
    for (const MaterialParameter& p : parameters) SetParameter({p.name, p.values}, made);
    return made;
  });
  material.name = name.empty() ? fmt::format("{} {}", bsdf, scene.materials.size()) : name;
  scene.materials.push_back(std::move(material));
  try {
    Translated([&] { CheckMaterials(scene, "material"); });
  } catch (...) {
    scene.materials.pop_back();
    throw;
  }
  state_->changed = true;
  return int(scene.materials.size()) - 1;
}

void Scene::AddMesh(const MeshArrays& mesh) {
  const std::size_t vertices = CountVertices(mesh.positions);
  const std::size_t triangles = mesh.triangles.size() / 3;
  Require(
      triangles < kMaxRecords, "triangles",
      fmt::format("there are {} triangles, and a mesh has fewer than {}", triangles, kMaxRecords));
  CheckLook(mesh, vertices, state_->scene());
  AppendMesh(*state_, mesh,
             {.positions = Rows<glm::vec3>(mesh.positions, vertices, "positions"),
              .normals = UnitNormals(mesh.normals, vertices),
              .uvs = Rows<glm::vec2>(mesh.uvs, vertices, "uvs"),
              .colors = Rows<glm::vec3>(mesh.colors, vertices, "colors"),
              .alphas = {mesh.alphas.begin(), mesh.alphas.end()},
              .triangles = Triangles(mesh.triangles, vertices)});
}

void Scene::AddPoints(const PointArrays& points) {
  const std::size_t vertices = CountVertices(points.positions);
  CheckLook(points, vertices, state_->scene());
  Require(points.diameter > 0 && std::isfinite(points.diameter), "diameter",
          fmt::format("{} is no length", points.diameter));
  const Mesh centres = {.positions = Rows<glm::vec3>(points.positions, vertices, "positions"),
                        .colors = Rows<glm::vec3>(points.colors, vertices, "colors"),
                        .alphas = {points.alphas.begin(), points.alphas.end()}};
  PointsAndLines parts;
  if (points.lines.empty())
    parts = AllPoints(centres);
  else
    parts.lines = Lines(points.lines, vertices);
  Mesh mesh = Translated([&] {
    return MakePoints(centres, parts, points.diameter, ReadOptions{}.max_triangles, "positions");
  });
  AppendMesh(*state_, points, std::move(mesh));
}

int Scene::AddObject(const std::string& name) {
  std::vector<Object>& objects = state_->Change().objects;
  objects.push_back(
      {.name = name.empty() ? fmt::format("object {}", objects.size()) : name, .meshes = {}});
  state_->changed = true;
  return int(objects.size()) - 1;
}

void Scene::AddInstances(int object, std::span<const float> matrices) {
  RequireObject(state_->scene(), object);
  Require(matrices.size() % 12 == 0, "matrices",
          fmt::format("there are {} values, and each instance needs 12", matrices.size()));
  RequireFinite(matrices, "matrices");
  Require(matrices.size() / 12 <= kMaxInstances - state_->scene().instances.size(), "matrices",
          fmt::format("a scene has at most {} instances", kMaxInstances));
  skywave::Scene& scene = state_->Change();
  for (std::size_t first = 0; first < matrices.size(); first += 12) {
    Instance instance = {.object = std::uint32_t(object),
                         .world_from_object = {},
                         .meshes_before = std::uint32_t(scene.meshes.size())};
    for (int i = 0; i < 12; ++i) {
      instance.world_from_object[i % 4][i / 4] = matrices[first + std::size_t(i)];
    }
    instance.world_from_object[3] -= scene.origin;
    scene.instances.push_back(instance);
  }
  state_->changed = true;
}

void Scene::AddPointLight(const Vector& position, const Vector& intensity) {
  RequireFinite(position, "position");
  state_->Change().lights.push_back({.kind = LocalLightKind::kPoint,
                                     .emission = Emission(intensity, "intensity"),
                                     .position = PlaceInScene(state_->scene(), Vec3(position))});
  state_->changed = true;
}

void Scene::AddSpotLight(const Vector& position, const Vector& axis, const Vector& intensity,
                         float full_degrees, float dark_degrees) {
  RequireFinite(position, "position");
  Require(dark_degrees > 0 && dark_degrees <= 180, "dark_degrees",
          "has to be greater than 0 and at most 180");
  Require(full_degrees >= 0 && full_degrees <= dark_degrees, "full_degrees",
          "a spot needs 0 <= full_degrees <= dark_degrees");
  state_->Change().lights.push_back({.kind = LocalLightKind::kSpot,
                                     .emission = Emission(intensity, "intensity"),
                                     .position = PlaceInScene(state_->scene(), Vec3(position)),
                                     .direction = Direction(axis, "axis"),
                                     .cos_full = std::cos(glm::radians(full_degrees)),
                                     .cos_dark = std::cos(glm::radians(dark_degrees))});
  state_->changed = true;
}

void Scene::AddDistantLight(const Vector& direction, const Vector& irradiance) {
  state_->Change().lights.push_back({.kind = LocalLightKind::kDistant,
                                     .emission = Emission(irradiance, "irradiance"),
                                     .direction = Direction(direction, "direction")});
  state_->changed = true;
}

void Scene::SetEnvironment(const ImageArray& map) {
  skywave::Image copy = CopyImage(map, "map");
  Require(std::any_of(copy.rgb.begin(), copy.rgb.end(),
                      [](float x) { return std::isfinite(x) && x > 0; }),
          "map", "is black: no pixel is positive");
  state_->environment_hash = MapHash(copy);
  state_->environment = std::make_shared<const skywave::Image>(std::move(copy));
  state_->changed = true;
}

void Scene::SetCamera(const Vector& eye, const Vector& target, const Vector& up,
                      float fov_degrees) {
  RequireFinite(eye, "eye");
  RequireFinite(target, "target");
  const glm::vec3 view = Vec3(target) - Vec3(eye);
  Require(glm::length(view) > 0, "target", "is where the eye is");
  const glm::vec3 unit_up = Direction(up, "up");
  Require(glm::length(glm::cross(view, unit_up)) > 1e-6f * glm::length(view), "up",
          "is the direction of the view");
  Require(fov_degrees > 0 && fov_degrees < 180, "fov_degrees", "has to be between 0 and 180");
  state_->camera =
      LookAtCamera(Vec3(eye), Vec3(target), unit_up, fov_degrees, state_->scene().left_handed);
  state_->camera_at = Vec3(eye);
  state_->changed = true;
}

void Scene::SetCamera(const std::array<double, 9>& k,
                      const std::array<double, 16>& world_from_camera, int width, int height) try {
  glm::dmat4 pose;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      pose[column][row] = world_from_camera[std::size_t(4 * row + column)];
    }
  }
  Require(pose[0][3] == 0 && pose[1][3] == 0 && pose[2][3] == 0 && pose[3][3] == 1,
          "world_from_camera", "has another last row than 0, 0, 0, 1");
  state_->camera = CameraOfMatrix(k, pose, width, height);
  state_->camera_at = glm::dvec3(pose[3]);
  state_->changed = true;
} catch (const InputError& error) {
  Require(false, "camera", error.reason());
}

void Scene::SetUp(char axis) {
  Require(axis == 'x' || axis == 'y' || axis == 'z', "axis", "is x, y or z");
  state_->Change().up_axis = axis;
  state_->changed = true;
}

std::vector<std::string> OptionsOfReading() {
  std::vector<std::string> names;
  for (const JobOption& option : JobOptions()) {
    if (option.of_reading) names.emplace_back(option.name);
  }
  return names;
}

std::size_t Scene::triangles() const {
  std::size_t triangles = 0;
  for (const Mesh& mesh : state_->scene().meshes) triangles += mesh.triangles.size();
  for (const Object& object : state_->scene().objects) {
    for (const Mesh& mesh : object.meshes) triangles += mesh.triangles.size();
  }
  return triangles;
}

}  // namespace skywave::api
