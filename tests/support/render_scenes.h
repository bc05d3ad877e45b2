// Small scenes for tests of whole renders, and the request that renders one.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>

#include "job/job.h"
#include "scene/builtin/scene_building.h"
#include "scene/shapes/shapes.h"

namespace skywave {

// Returns a map whose texels the engine's packed form holds exactly (kernels/lights/environment.h):
// channels are rounded to 8 bits of the texel's brightest channel.
inline Image Packable(Image map) {
  for (std::size_t i = 0; i < map.rgb.size(); i += 3) {
    const float brightest = std::max({map.rgb[i], map.rgb[i + 1], map.rgb[i + 2]});
    if (!(brightest > 0)) continue;
    const float unit = std::ldexp(1.0f, std::ilogb(brightest) - 7);
    for (std::size_t c = 0; c < 3; ++c) map.rgb[i + c] = std::round(map.rgb[i + c] / unit) * unit;
  }
  return map;
}

// Returns a sky of smooth colours, brighter above the horizon, with a sun of the given radiance
// that covers all texels within `radius` [rad] of its centre. The sun is left of the middle of the
// map.
inline Image SkyWithSun(int width, int height, float sun, double radius) {
  Image map(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double theta = M_PI * (y + 0.5) / height, phi = 2 * M_PI * ((x + 0.5) / width - 0.5);
      const double cosine =
          std::cos(theta) * std::cos(0.8) + std::sin(theta) * std::sin(0.8) * std::cos(phi + 0.9);
      float* const rgb = map.Pixel(x, y);
      const bool lit = std::acos(std::clamp(cosine, -1.0, 1.0)) < radius;
      const double up = std::cos(theta), side = std::sin(phi);
      rgb[0] = float(lit ? sun : 0.30 + 0.10 * up + 0.10 * side);
      rgb[1] = float(lit ? 0.9 * sun : 0.35 + 0.20 * up - 0.05 * side);
      rgb[2] = float(lit ? 0.7 * sun : 0.40 + 0.35 * up);
    }
  }
  return Packable(map);
}

inline void SetLight(Scene& scene, Image map,
                     const glm::mat3& world_from_map = EnvironmentFrame('y', false, 0)) {
  EnvironmentLight light;
  light.map = std::move(map);
  light.world_from_map = world_from_map;
  scene.environments = {std::move(light)};
}
inline void SetConstantLight(Scene& scene, float radiance) {
  scene.environments = {
      {.scale = glm::vec3(radiance), .world_from_map = EnvironmentFrame('y', false, 0)}};
}

// Returns the same triangles without normals, for flat shading.
inline Mesh Facetted(Mesh mesh) {
  mesh.normals.clear();
  return mesh;
}

// Returns a small job with default values for everything that tests do not set.
inline JobRequest SmallRequest(int width, int height, std::uint32_t samples_per_pixel) {
  JobRequest request;
  request.scene = "test";
  request.width = width, request.height = height;
  request.samples_per_pixel = samples_per_pixel;
  request.options.threads = 2;
  request.options.wave = 512;
  return request;
}

// Lights for small rooms about the origin: a spot from the upper right and a sun from the upper
// left.
inline PunctualLight SlantingSpot() {
  return {.kind = LocalLightKind::kSpot,
          .emission = {9, 5, 4},
          .position = {1.8f, 3, 0.6f},
          .direction = glm::normalize(glm::vec3(-0.7f, -1, 0)),
          .cos_full = 0.97f,
          .cos_dark = 0.85f};
}
// Returns lights with a shape: a stretched spot, an image on the sphere around a point and a
// projected image, whose images are added to the scene. Few texels shine, some are black.
inline std::vector<PunctualLight> ShapedLights(Scene& scene) {
  Image square(4, 4), picture(6, 3);
  for (int i = 0; i < 48; ++i) square.rgb[std::size_t(i)] = float(i / 3 * 7 % 5) * 0.5f;
  for (int i = 0; i < 54; ++i) picture.rgb[std::size_t(i)] = float(i * 5 % 7 % 4);
  scene.images.push_back(square);
  scene.images.push_back(picture);
  const auto index = std::uint32_t(scene.images.size());
  // The columns are the axes of the light; the second one is longer and no axis is at right angles.
  const glm::mat3 sheared = glm::mat3(1, 0.1f, 0.2f, 0.3f, 0.4f, 2, 0.4f, -1, 0);
  PunctualLight spot = {.kind = LocalLightKind::kShaped, .emission = {9, 5, 4}};
  spot.position = {-0.6f, 2.8f, 0.6f};
  spot.cos_full = 0.97f, spot.cos_dark = 0.85f;
  spot.form = LightForm{.mapping = LightMapping::kCone, .world_from_light = sheared};
  PunctualLight sphere = {.kind = LocalLightKind::kShaped, .emission = {1, 2, 3}};
  sphere.position = {-1.6f, 2.1f, 1.1f};
  sphere.form = LightForm{.mapping = LightMapping::kSphere,
                          .world_from_light = 3.0f * glm::mat3(0, 0, -1, 0, 1, 0, 1, 0, 0),
                          .image = index - 2};
  PunctualLight plane = {.kind = LocalLightKind::kShaped, .emission = {3, 2, 2}};
  plane.position = {1.7f, 2.2f, 1.5f};
  plane.form = LightForm{
      .mapping = LightMapping::kPlane,
      .world_from_light = glm::mat3(0.7f, 0, -0.7f, -0.5f, 1.5f, -0.4f, -0.9f, -0.8f, -0.8f),
      .image = index - 1,
      .half_size = {0.8f, 0.4f}};
  return {spot, sphere, plane};
}
inline PunctualLight SlantingSun() {
  return {.kind = LocalLightKind::kDistant,
          .emission = {0.5f, 0.4f, 0.3f},
          .direction = glm::normalize(glm::vec3(-1, 2, 0.5f))};
}

// Places a room with an opening in its roof.
inline void PlaceRoom(Scene& scene, std::uint32_t material) {
  const auto wall = [&](const glm::vec3& centre, const glm::vec3& half) {
    Place(scene, Facetted(RoundedBox(half, 0.01f, 1)), material, centre);
  };
  wall({0, 0, 0}, {2, 0.05f, 2});
  wall({0, 1, -2}, {2, 1, 0.05f}), wall({0, 1, 2}, {2, 1, 0.05f});
  wall({-2, 1, 0}, {0.05f, 1, 2}), wall({2, 1, 0}, {0.05f, 1, 2});
  wall({-1.2f, 2, 0}, {0.8f, 0.05f, 2}), wall({1.2f, 2, 0}, {0.8f, 0.05f, 2});
  wall({0, 2, -1.2f}, {0.4f, 0.05f, 0.8f}), wall({0, 2, 1.2f}, {0.4f, 0.05f, 0.8f});
}

// Returns such a room under a sky with a sun, seen from inside.
inline Scene RoomUnderSkylight() {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "white", glm::vec3(0.7f));
  PlaceRoom(scene, white);
  Place(scene, Quad(0.2f), AddMirror(scene, 0.9f), {0.2f, 1.2f, 0});
  Place(scene, Sphere(0.3f), AddMetal(scene, "Cu", 0.3f), {-0.6f, 0.4f, -0.5f});
  scene.camera = LookAtCamera({1.2f, 1.2f, 1.5f}, {-0.3f, 0.5f, -0.4f}, {0, 1, 0}, 70, false);
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  return scene;
}

}  // namespace skywave
