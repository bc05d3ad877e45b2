// Screens with alpha of every kind, behind each other and over a floor with a normal map, for tests
// of whole renders.
#pragma once

#include <glm/gtc/matrix_transform.hpp>

#include "scene/shapes/mesh.h"
#include "tests/support/render_scenes.h"

namespace skywave {

// Returns an image of a single colour.
inline Image Plain(const glm::vec3& color) {
  Image image(1, 1);
  for (int c = 0; c < 3; ++c) image.rgb[std::size_t(c)] = color[c];
  return image;
}

// Returns side x side alternating squares.
inline Image Checkers(int side, float even, float odd) {
  Image image(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      std::fill_n(image.Pixel(x, y), 3, (x + y) % 2 == 0 ? even : odd);
    }
  }
  return image;
}

// Returns the colour that represents a normal (of any length) in a map.
inline glm::vec3 NormalColor(const glm::vec3& normal) {
  return 0.5f * glm::normalize(normal) + 0.5f;
}

inline Scene ScreensScene() {
  Scene scene;
  Image normals(3, 2);
  const glm::vec2 tilts[] = {{0, 0},        {0.4f, 0}, {0, -0.5f},
                             {-0.4f, 0.2f}, {0, 0.5f}, {0.2f, -0.2f}};
  for (int i = 0; i < 6; ++i) {
    const glm::vec3 color = NormalColor(glm::vec3(tilts[i], 1));
    for (int c = 0; c < 3; ++c) normals.Pixel(i % 3, i / 3)[c] = color[c];
  }
  scene.images = {Checkers(4, 0.25f, 0.75f), normals, Checkers(2, 0, 1)};
  scene.textures = {
      {.image = 0, .use = TextureUse::kOpacity},
      {.image = 1, .transform = {1, 0.5f, -0.5f, 1, 0.2f, 0}, .use = TextureUse::kNormals},
      {.image = 2, .wrap_u = TextureWrap::kClamp, .use = TextureUse::kOpacity}};
  const std::uint32_t floor = AddLambert(scene, "floor", {0.9f, 0.8f, 0.7f});
  scene.materials[floor].normal_texture = 1;
  scene.materials.push_back({.name = "relief",
                             .bsdf = BsdfKind::kMetallicRoughness,
                             .reflectance = {0.9f, 0.6f, 0.3f},
                             .alpha = 0.4f,
                             .metallic = 0.7f,
                             .opacity = 0.8f,
                             .normal_texture = 1,
                             .normal_scale = 0.5f});
  const std::uint32_t veil = AddLambert(scene, "veil", {0.2f, 0.5f, 0.8f});
  scene.materials[veil].opacity = 0.9f;
  scene.materials[veil].opacity_texture = 0;
  const std::uint32_t grid = AddLambert(scene, "grid", glm::vec3(0.7f));
  scene.materials[grid].opacity_texture = 2;
  scene.materials[grid].opacity_cutoff = 0.6f;
  Place(scene, Quad(4), floor, {0, 0, 0}, 10);
  Place(scene, Quad(0.8f), veil, {-0.4f, 0.9f, 0.3f}, 30);
  Place(scene, Quad(0.8f), veil, {-0.2f, 1.2f, 0.2f}, 70);
  Place(scene, Quad(0.7f), grid, {0.8f, 0.7f, 0.4f}, 20);
  Place(scene, Quad(0.6f), 1, {0.2f, 0.4f, 0.9f}, 40);
  Mesh wall = Facetted(Quad(0.7f));
  TransformMesh(glm::rotate(glm::dmat4(1), glm::radians(80.0), glm::dvec3(1, 0, 0.2)), wall);
  Place(scene, wall, 1, {-1.2f, 0.7f, -0.8f});
  Place(scene, Sphere(0.3f, 4), AddGlass(scene, 1.5f), {1.0f, 0.3f, 1.4f});
  scene.camera = LookAtCamera({0.4f, 2.1f, 3.5f}, {0, 0.3f, 0}, {0, 1, 0}, 60, false);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
  return scene;
}

}  // namespace skywave
