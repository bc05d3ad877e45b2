#include "scene/builtin/builtin.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>
#include <vector>

#include "base/error.h"
#include "scene/builtin/scene_building.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/shapes.h"

namespace skywave {
namespace {

constexpr std::array kScenes = {
    BuiltinSceneInfo{"gallery",
                     "a still life in the sun: stone, glaze, gold, copper, mirror, glass"},
    BuiltinSceneInfo{"spheres", "one sphere of each BSDF on a plane under the sun"},
    BuiltinSceneInfo{"furnace", "a white sphere in constant radiance 1: everything renders to 1"},
    BuiltinSceneInfo{"lamps",
                     "a room with a lamp in its ceiling, a spot, a bulb and a glowing ball"},
    BuiltinSceneInfo{"room", "an interior that daylight reaches through one window"},
    BuiltinSceneInfo{"three-spheres", "mirror, glass and chalk on a slab under the sun: caustics"},
    BuiltinSceneInfo{"many-shapes", "a field of 196 blobs, 1.0 M triangles of Lambert"},
    BuiltinSceneInfo{"many-materials", "the same field with every BSDF"},
    BuiltinSceneInfo{"materials", "a sphere of each BSDF under the sun"},
    BuiltinSceneInfo{"plant", "leaves and a flower, 20 000 triangles"},
    BuiltinSceneInfo{"meadow", "100 000 instances of the plant"},
};

Scene SpheresScene() {
  Scene scene;
  Place(scene, Quad(200), AddLambert(scene, "floor", glm::vec3(0.45f)), glm::vec3(0));
  const std::uint32_t materials[] = {AddLambert(scene, "red", {0.6f, 0.12f, 0.08f}),
                                     AddMetal(scene, "Au", 0.2f), AddMirror(scene, 0.95f),
                                     AddGlass(scene, 1.5f)};
  for (int i = 0; i < 4; ++i) Place(scene, Sphere(0.5f), materials[i], {1.2f * i - 1.8f, 0.5f, 0});
  AddProceduralSky(scene);
  scene.camera = LookAtCamera({0, 1.5f, 5}, {0, 0.45f, 0}, {0, 1, 0}, 38, false);
  scene.settings = BuiltinSettings(64, 10);
  return scene;
}

Scene FurnaceScene() {
  Scene scene;
  Place(scene, Sphere(1), AddLambert(scene, "white", glm::vec3(1)), glm::vec3(0));
  scene.environments.push_back({.world_from_map = EnvironmentFrame('y', false, 0)});
  scene.camera = LookAtCamera({0, 0, 4}, glm::vec3(0), {0, 1, 0}, 40, false);
  scene.settings = BuiltinSettings(64, 8);
  return scene;
}

// Adds a quad centred at `centre` whose normal is the axis-aligned `normal`.
void PlaceWall(Scene& scene, float half, std::uint32_t material, const glm::vec3& centre,
               const glm::vec3& normal) {
  const glm::vec3 from(0, 1, 0), axis = glm::cross(from, normal);
  glm::dmat4 turn(1);
  if (glm::length(axis) > 0) {
    turn = glm::rotate(glm::dmat4(1), glm::half_pi<double>(), glm::dvec3(axis));
  } else if (normal.y < 0) {
    turn = glm::rotate(glm::dmat4(1), glm::pi<double>(), glm::dvec3(1, 0, 0));
  }
  Mesh wall = Quad(half);
  TransformMesh(turn, wall);
  Place(scene, std::move(wall), material, centre);
}

// A room of 4 x 4 x 4, open towards the camera, without an environment. It is lit by every kind of
// local light except distant ones, which would be blocked by the walls.
Scene LampsScene() {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "white", glm::vec3(0.7f));
  const std::uint32_t red = AddLambert(scene, "brick", {0.55f, 0.14f, 0.08f});
  const std::uint32_t blue = AddLambert(scene, "slate", {0.12f, 0.22f, 0.40f});
  PlaceWall(scene, 2, white, {0, 0, 0}, {0, 1, 0});
  PlaceWall(scene, 2, white, {0, 4, 0}, {0, -1, 0});
  PlaceWall(scene, 2, white, {0, 2, -2}, {0, 0, 1});
  PlaceWall(scene, 2, red, {-2, 2, 0}, {1, 0, 0});
  PlaceWall(scene, 2, blue, {2, 2, 0}, {-1, 0, 0});
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0.6f));
  scene.materials[lamp].emission = {9, 8.2f, 7};
  PlaceWall(scene, 0.45f, lamp, {0, 3.98f, 0}, {0, -1, 0});
  const std::uint32_t glow = AddLambert(scene, "glow", glm::vec3(0.2f));
  scene.materials[glow].emission = {4, 1.4f, 0.3f};
  Place(scene, Sphere(0.18f, 6), glow, {1.2f, 0.18f, 0.9f});
  Place(scene, Sphere(0.55f), AddMetal(scene, "Au", 0.2f), {-0.85f, 0.55f, -0.5f});
  Place(scene, Sphere(0.45f), AddGlass(scene, 1.5f), {0.35f, 0.45f, 0.55f});
  Place(scene, RoundedBox({0.4f, 0.8f, 0.4f}, 0.04f, 6), white, {0.95f, 0.8f, -0.8f}, 25);
  const glm::vec3 spot(-1.7f, 3.6f, 1.6f), target(-0.85f, 0, -0.5f);
  scene.lights.push_back({.kind = LocalLightKind::kSpot,
                          .emission = {14, 16, 20},
                          .position = spot,
                          .direction = glm::normalize(target - spot),
                          .cos_full = std::cos(glm::radians(13.0f)),
                          .cos_dark = std::cos(glm::radians(19.0f))});
  scene.lights.push_back({.kind = LocalLightKind::kPoint,
                          .emission = {0.5f, 0.55f, 0.4f},
                          .position = {1.6f, 2.4f, -1.6f}});
  scene.camera = LookAtCamera({0, 2, 8.2f}, {0, 1.9f, 0}, {0, 1, 0}, 38, false);
  scene.settings = BuiltinSettings(128, 8);
  return scene;
}

// The scene is small so that many light paths from the environment hit it; it is the scene for
// photon-mapped caustics.
Scene ThreeSpheresScene() {
  Scene scene;
  Place(scene, Quad(2.6f), AddLambert(scene, "slab", {0.62f, 0.58f, 0.52f}), glm::vec3(0));
  const std::uint32_t materials[] = {AddMirror(scene, 0.95f), AddGlass(scene, 1.5f),
                                     AddLambert(scene, "chalk", {0.75f, 0.32f, 0.22f})};
  const glm::vec3 places[] = {{-1.15f, 0.6f, -0.35f}, {0.15f, 0.6f, 0.55f}, {1.2f, 0.6f, -0.45f}};
  for (int i = 0; i < 3; ++i) Place(scene, Sphere(0.6f), materials[i], places[i]);
  AddProceduralSky(scene);
  scene.camera = LookAtCamera({0.3f, 2.3f, 4.6f}, {0, 0.35f, 0}, {0, 1, 0}, 38, false);
  scene.settings = BuiltinSettings(64, 8);
  return scene;
}

// Returns a sphere with a few waves in its surface; each seed gives different waves.
Mesh Blob(int seed) {
  Mesh blob = Sphere(0.42f, 16);
  const float phase = 1.7f * static_cast<float>(seed);
  Displace(blob, [phase](const glm::vec3& p) {
    return 0.05f * std::sin(9 * p.x + phase) * std::cos(8 * p.y - 2 * phase) +
           0.04f * std::sin(13 * p.z + 3 * phase) + 0.02f * std::cos(23 * p.y + 19 * p.x + phase);
  });
  return blob;
}

std::vector<Material> FiveColors() {
  return {{.name = "white", .reflectance = glm::vec3(0.75f)},
          {.name = "red", .reflectance = {0.6f, 0.12f, 0.08f}},
          {.name = "green", .reflectance = {0.15f, 0.4f, 0.12f}},
          {.name = "blue", .reflectance = {0.1f, 0.2f, 0.5f}},
          {.name = "yellow", .reflectance = {0.7f, 0.5f, 0.1f}}};
}

// Which of `count` materials the blob of a number has: the scores of benchmarks are of these
// colors.
std::uint32_t ColorOf(std::uint32_t blob, std::uint32_t count) {
  return (2654435761u * (blob + 1) >> 16) % count;
}

// Multiples of the golden ratio take all of them equally often (Fibonacci hashing).
std::uint32_t BsdfOf(std::uint32_t blob, std::uint32_t count) {
  const std::uint64_t golden = 2654435761u * (blob + 1);
  return std::uint32_t(golden * count >> 32);
}

Scene ManyShapesScene(const std::vector<Material>& materials,
                      std::uint32_t (*material_of)(std::uint32_t blob, std::uint32_t count)) {
  constexpr int kSide = 14;  // 14 * 14 blobs of 5120 triangles
  Scene scene;
  Place(scene, Quad(200), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  scene.materials.insert(scene.materials.end(), materials.begin(), materials.end());
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const int seed = i * kSide + j;
      const std::uint32_t material =
          1 + material_of(std::uint32_t(seed), std::uint32_t(materials.size()));
      Place(scene, Blob(seed), material, {i - 0.5f * (kSide - 1), 0.45f, 0.5f * (kSide - 1) - j},
            37.0f * seed);
    }
  }
  AddProceduralSky(scene);
  scene.camera = LookAtCamera({4, 5.5f, 13}, {0, 0, 0.5f}, {0, 1, 0}, 38, false);
  scene.settings = BuiltinSettings(32, 6);
  return scene;
}

}  // namespace

std::span<const BuiltinSceneInfo> BuiltinScenes() { return kScenes; }

Scene BuiltinScene(const std::string& name) {
  if (name == "gallery") return GalleryScene();
  if (name == "spheres") return SpheresScene();
  if (name == "furnace") return FurnaceScene();
  if (name == "lamps") return LampsScene();
  if (name == "room") return RoomScene();
  if (name == "three-spheres") return ThreeSpheresScene();
  if (name == "many-shapes") return ManyShapesScene(FiveColors(), ColorOf);
  if (name == "many-materials") return ManyShapesScene(OneOfEachBsdf(), BsdfOf);
  if (name == "materials") return MaterialsScene();
  if (name == "plant") return PlantScene();
  if (name == "meadow") return MeadowScene();
  if (name == "-") {
    throw InputError(InputPosition::File("-"),
                     "scenes are not read from standard input: the files that they name lie beside "
                     "theirs");
  }
  std::string known;
  for (const BuiltinSceneInfo& info : kScenes) {
    known += fmt::format("{}{}", known.empty() ? "" : ", ", info.name);
  }
  throw InputError(InputPosition::File(name),
                   fmt::format("there is no such file; the built-in scenes are {}", known));
}

}  // namespace skywave
