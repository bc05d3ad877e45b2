// The built-in scene "gallery" is a still life on a stone terrace in the afternoon sun.
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "scene/builtin/scene_building.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/shapes.h"

namespace skywave {
namespace {

// Adds a round terrace of square tiles with worn edges, whose tops are at y = 0, and the ground
// around it.
void AddTerrace(Scene& scene) {
  constexpr float kRadius = 8.5f, kTile = 1, kGap = 0.025f, kThickness = 0.12f, kTurn = 27;
  const std::uint32_t light = AddLambert(scene, "light stone", {0.62f, 0.57f, 0.50f});
  const std::uint32_t dark = AddLambert(scene, "dark stone", {0.40f, 0.38f, 0.36f});
  const std::uint32_t ground = AddLambert(scene, "ground", {0.34f, 0.31f, 0.26f});
  const Mesh tile =
      RoundedBox({0.5f * (kTile - kGap), 0.5f * kThickness, 0.5f * (kTile - kGap)}, 0.02f, 2);
  const int extent = static_cast<int>(kRadius / kTile);
  const float angle = glm::radians(kTurn);
  for (int i = -extent; i <= extent; ++i) {
    for (int j = -extent; j <= extent; ++j) {
      const float x = i * kTile, z = j * kTile;
      if (std::hypot(x, z) > kRadius) continue;
      const glm::vec3 centre(std::cos(angle) * x + std::sin(angle) * z, -0.5f * kThickness,
                             -std::sin(angle) * x + std::cos(angle) * z);
      Place(scene, tile, (i + j) % 2 == 0 ? light : dark, centre, kTurn);
    }
  }
  Place(scene, Quad(400), ground, {0, -0.75f * kThickness, 0});
}

// Returns a closed vase with a rim, about 1.75 high: the profile goes up the outer wall and down
// the inner one.
Mesh Vase() {
  constexpr int kSteps = 96;
  constexpr float kHeight = 1.75f, kWall = 0.035f;
  const auto radius = [](float t) {  // t in [0, 1] runs from foot to rim
    const float belly = std::sin(glm::pi<float>() * std::pow(t, 0.75f));
    const float lip = 0.16f * std::pow(t, 14.0f);
    return 0.20f + 0.30f * belly + lip + 0.012f * std::cos(26 * t);
  };
  std::vector<glm::vec2> profile = {{0, 0}, {0.5f * radius(0), 0}};
  for (int i = 0; i <= kSteps; ++i) {
    const float t = float(i) / kSteps;
    profile.emplace_back(radius(t), kHeight * t);
  }
  for (int i = kSteps; i >= 4; --i) {
    const float t = float(i) / kSteps;
    profile.emplace_back(radius(t) - kWall, kHeight * t);
  }
  profile.emplace_back(0, kHeight * 4 / kSteps);
  return Revolve(profile, 128);
}

// Returns a shallow bowl of radius 1 with a wall, on a small foot.
Mesh Bowl() {
  constexpr int kSteps = 48;
  std::vector<glm::vec2> profile = {{0, 0}, {0.3f, 0}, {0.34f, 0.03f}};
  for (int i = 11; i <= kSteps; ++i) {  // above the foot
    const float angle = glm::half_pi<float>() * i / kSteps;
    profile.emplace_back(std::sin(angle), 0.62f - 0.6f * std::cos(angle));
  }
  for (int i = kSteps; i >= 1; --i) {
    const float angle = glm::half_pi<float>() * i / kSteps;
    profile.emplace_back(0.95f * std::sin(angle), 0.62f - 0.55f * std::cos(angle));
  }
  profile.emplace_back(0, 0.07f);
  return Revolve(profile, 128);
}

Mesh Scaled(Mesh mesh, float factor) {
  TransformMesh(glm::scale(glm::dmat4(1), glm::dvec3(factor)), mesh);
  return mesh;
}

// Turns a mesh upright: its y axis becomes -z.
Mesh Upright(Mesh mesh) {
  TransformMesh(glm::rotate(glm::dmat4(1), glm::half_pi<double>(), glm::dvec3(1, 0, 0)), mesh);
  return mesh;
}

void AddSphere(Scene& scene, float radius, std::uint32_t material, float x, float z, float y = 0) {
  Place(scene, Sphere(radius), material, {x, y + radius, z});
}

}  // namespace

Scene GalleryScene() {
  Scene scene;
  AddTerrace(scene);
  const std::uint32_t white = AddLambert(scene, "plaster", {0.76f, 0.74f, 0.70f});
  const std::uint32_t teal = AddLambert(scene, "teal glaze", {0.06f, 0.33f, 0.36f});
  const std::uint32_t red = AddLambert(scene, "vermilion", {0.64f, 0.10f, 0.05f});
  const std::uint32_t yellow = AddLambert(scene, "ochre", {0.74f, 0.47f, 0.08f});
  const std::uint32_t blue = AddLambert(scene, "ultramarine", {0.09f, 0.14f, 0.46f});
  const std::uint32_t gold = AddMetal(scene, "Au", 0.18f);
  const std::uint32_t copper = AddMetal(scene, "Cu", 0.30f);
  const std::uint32_t aluminium = AddMetal(scene, "Al", 0.04f);
  const std::uint32_t mirror = AddMirror(scene, 0.95f);
  const std::uint32_t glass = AddGlass(scene, 1.5f);

  // The back row holds, from the left, a gold knot on a plinth, a vase, a mirror sphere and a blue
  // block.
  Place(scene, RoundedBox({0.62f, 0.31f, 0.62f}, 0.05f, 6), white, {-1.75f, 0.31f, -0.55f}, 18);
  Place(scene, Upright(TorusKnot(2, 3, 0.40f, 0.19f, 0.105f, 420, 40)), gold,
        {-1.75f, 1.30f, -0.55f}, 24);
  Place(scene, Vase(), teal, {-0.10f, 0, -1.15f});
  AddSphere(scene, 0.72f, mirror, 1.45f, -0.75f);
  Place(scene, RoundedBox({0.30f, 0.85f, 0.30f}, 0.04f, 6), blue, {2.65f, 0.85f, -1.35f}, -32);
  AddSphere(scene, 0.26f, yellow, 2.65f, -1.35f, 1.70f);

  // The front row holds a copper bowl with a fruit, a glass sphere and an aluminium ring around a
  // red ball.
  Place(scene, Scaled(Bowl(), 0.58f), copper, {-0.95f, 0, 0.62f});
  AddSphere(scene, 0.24f, yellow, -0.98f, 0.56f, 0.05f);
  AddSphere(scene, 0.46f, glass, 0.35f, 0.70f);
  Place(scene, TorusKnot(1, 0, 0.42f, 0, 0.11f, 160, 48), aluminium, {1.62f, 0.11f, 0.75f});
  AddSphere(scene, 0.21f, red, 1.62f, 0.75f);
  AddSphere(scene, 0.15f, red, -0.28f, 1.45f);
  AddSphere(scene, 0.12f, blue, 0.86f, 1.50f);
  Place(scene, RoundedBox(glm::vec3(0.15f), 0.03f, 5), white, {-1.85f, 0.15f, 0.85f}, 40);

  AddProceduralSky(scene);
  scene.camera = LookAtCamera({0.55f, 2.05f, 6.6f}, {0.30f, 0.72f, 0}, {0, 1, 0}, 34, false);
  scene.settings = BuiltinSettings(64, 12);
  return scene;
}

}  // namespace skywave
