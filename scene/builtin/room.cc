// The built-in scene "room" is an interior lit only by daylight through one window.
#include <array>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/scene_building.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/shapes.h"

namespace skywave {
namespace {

// Places a rectangle centred at `centre` whose half sides are `half_u` and `half_v`; it faces
// `half_u` x `half_v`.
void PlacePanel(Scene& scene, std::uint32_t material, const glm::dvec3& centre,
                const glm::dvec3& half_u, const glm::dvec3& half_v) {
  // Quad(1) spans x and z and faces y, which is z cross x.
  const glm::dmat4 place(glm::dvec4(half_v, 0), glm::dvec4(glm::cross(half_u, half_v), 0),
                         glm::dvec4(half_u, 0), glm::dvec4(centre, 1));
  Mesh panel = Quad(1);
  TransformMesh(place, panel);
  Place(scene, std::move(panel), material, glm::vec3(0));
}

// The edges of the window in y and z.
constexpr double kSill = 0.9, kLintel = 2.1, kBack = -0.5, kFront = 0.9;

// Builds a wall in the plane x = -2 around its window: below, above, behind and in front of it.
void PlaceWindowWall(Scene& scene, std::uint32_t material) {
  const auto part = [&](double y0, double y1, double z0, double z1) {
    PlacePanel(scene, material, {-2, 0.5 * (y0 + y1), 0.5 * (z0 + z1)}, {0, 0.5 * (y1 - y0), 0},
               {0, 0, 0.5 * (z1 - z0)});
  };
  part(0, kSill, -2.5, 2.5);
  part(kLintel, 2.6, -2.5, 2.5);
  part(kSill, kLintel, -2.5, kBack);
  part(kSill, kLintel, kFront, 2.5);
}

// Returns the window; light comes in along +x.
Portal Window() {
  return {.corner = {-2, kSill, kBack},
          .side_x = {0, 0, float(kFront - kBack)},
          .side_y = {0, float(kLintel - kSill), 0}};
}

}  // namespace

// The room is 4 wide, 2.6 high and 5 deep. The camera stands inside; the sun comes from the left,
// over its shoulder.
Scene RoomScene() {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "plaster", {0.76f, 0.74f, 0.70f});
  const std::uint32_t wood = AddLambert(scene, "wood", {0.46f, 0.29f, 0.17f});
  const std::uint32_t green = AddLambert(scene, "green", {0.26f, 0.42f, 0.30f});
  PlacePanel(scene, wood, {0, 0, 0}, {0, 0, 2.5}, {2, 0, 0});
  PlacePanel(scene, white, {0, 2.6, 0}, {2, 0, 0}, {0, 0, 2.5});
  PlacePanel(scene, green, {0, 1.3, -2.5}, {2, 0, 0}, {0, 1.3, 0});
  PlacePanel(scene, white, {0, 1.3, 2.5}, {0, 1.3, 0}, {2, 0, 0});
  PlacePanel(scene, white, {2, 1.3, 0}, {0, 0, 2.5}, {0, 1.3, 0});
  PlaceWindowWall(scene, white);

  Place(scene, RoundedBox({0.75f, 0.03f, 0.5f}, 0.02f, 4), wood, {0.1f, 0.72f, -1.1f}, 12);
  for (const std::array<float, 2> leg : {std::array{-0.55f, -0.8f}, std::array{0.55f, -0.95f},
                                         std::array{-0.4f, -1.45f}, std::array{0.7f, -1.45f}}) {
    Place(scene, RoundedBox({0.04f, 0.35f, 0.04f}, 0.01f, 2), wood, {leg[0], 0.35f, leg[1]}, 12);
  }
  Place(scene, Sphere(0.2f), AddGlass(scene, 1.5f), {-0.25f, 0.95f, -1.0f});
  Place(scene, Sphere(0.16f), AddMetal(scene, "Cu", 0.15f), {0.3f, 0.91f, -1.2f});
  Place(scene, RoundedBox({0.3f, 0.45f, 0.3f}, 0.03f, 4), white, {1.35f, 0.45f, -1.9f}, 30);
  scene.portals = {Window()};
  AddProceduralSky(scene);
  scene.environments.back().scale = glm::vec3(3);  // the exposure of a camera indoors
  scene.camera = LookAtCamera({0.9f, 1.45f, 2.3f}, {-0.25f, 1.0f, -1.6f}, {0, 1, 0}, 58, false);
  scene.settings = BuiltinSettings(256, 8);
  return scene;
}

}  // namespace skywave
