// A room for tests of integrators that start paths at lights: matt walls, balls of any material,
// lights of all kinds.
#pragma once

#include "scene/shapes/mesh.h"
#include "tests/support/room_lights.h"

namespace skywave {

// Adds a rectangle parallel to the floor that emits downwards.
inline void AddLamp(Scene& scene, float size, const glm::vec3& centre, const glm::vec3& radiance) {
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0.3f));
  scene.materials[lamp].emission = radiance;
  Mesh mesh = Facetted(Quad(size / 2));
  FlipOrientation(mesh);
  Place(scene, mesh, lamp, centre);
}

// Returns a matt floor and wall and three faceted balls, the middle one of the given material. The
// balls are faceted because paths from the other side may see a different normal at the rim of
// smooth ones (design.md).
inline Scene MattRoom(const Material& material, int lights) {
  Scene scene;
  Place(scene, Facetted(Quad(4)), AddLambert(scene, "floor", {0.7f, 0.6f, 0.5f}), glm::vec3(0));
  Mesh wall = Facetted(Quad(3));
  for (glm::vec3& p : wall.positions) p = {p.x, p.z + 2, -2};
  Place(scene, wall, AddLambert(scene, "wall", {0.3f, 0.6f, 0.7f}), glm::vec3(0));
  scene.materials.push_back(material);
  const auto index = std::uint32_t(scene.materials.size() - 1);
  Place(scene, Facetted(Sphere(0.6f, 4)), index, {0, 0.65f, 0.2f});
  Place(scene, Facetted(Sphere(0.45f, 3)), AddLambert(scene, "red", {0.8f, 0.2f, 0.2f}),
        {-1.2f, 0.5f, 0});
  Place(scene, Facetted(Sphere(0.45f, 3)), index, {1.2f, 0.5f, 0.4f}, 30);
  if (lights & kLamp) AddLamp(scene, 1.2f, {0.2f, 2.6f, 0}, {5, 4, 3});
  if (lights & kBall) {
    const std::uint32_t ball = AddLambert(scene, "ball", glm::vec3(0.3f));
    scene.materials[ball].emission = {2, 5, 3};
    scene.materials[ball].emits_on_both_sides = true;
    Place(scene, Facetted(Sphere(0.2f, 2)), ball, {-0.5f, 0.35f, 1.2f});
  }
  if (lights & kPoint) scene.lights.push_back({.emission = {2, 2, 3}, .position = {-1.6f, 2, 1}});
  AddSlantingLights(scene, lights);
  // The map is constant because the eye sees a map interpolated while light paths do not
  // (design.md).
  if (lights & kEnvironment) SetConstantLight(scene, 0.5f);
  scene.camera = LookAtCamera({0.4f, 1.9f, 4.5f}, {0, 0.8f, 0}, {0, 1, 0}, 44, false);
  return scene;
}

inline Material Of(BsdfKind bsdf, float alpha = 0.3f) {
  return {
      .name = "tested",
      .bsdf = bsdf,
      .reflectance = {0.8f, 0.7f, 0.6f},
      .eta = bsdf == BsdfKind::kDiffuseTransmission ? glm::vec3(0.2f, 0.25f, 0.3f) : glm::vec3(0),
      .alpha = alpha,
      .ior = 1.5f};
}

}  // namespace skywave
