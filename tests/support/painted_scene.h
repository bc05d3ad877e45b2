// A scene with textures on every kind of parameter, for tests of whole renders.
#pragma once

#include "tests/support/render_scenes.h"

namespace skywave {

inline Scene PaintedScene() {
  Scene scene;
  Image colors(7, 5), numbers(4, 4);
  for (std::size_t i = 0; i < colors.rgb.size(); ++i) colors.rgb[i] = float(i % 11) / 10;
  for (std::size_t i = 0; i < numbers.rgb.size(); ++i) numbers.rgb[i] = float(i % 5) / 4;
  scene.images = {colors, numbers};
  scene.textures = {{.image = 0, .wrap_v = TextureWrap::kMirror, .transform = {3, 1, -1, 4, 0, 0}},
                    {.image = 1, .wrap_u = TextureWrap::kClamp}};
  const std::uint32_t floor = AddLambert(scene, "floor", {0.9f, 0.8f, 0.7f});
  scene.materials[floor].color_texture = 0;
  scene.materials.push_back({.name = "paint",
                             .bsdf = BsdfKind::kMetallicRoughness,
                             .reflectance = glm::vec3(0.9f),
                             .alpha = 0.5f,
                             .metallic = 0.8f,
                             .color_texture = 0,
                             .roughness_texture = 1});
  scene.materials.push_back({.name = "varnish",
                             .bsdf = BsdfKind::kMetallicRoughness,
                             .reflectance = {0.2f, 0.3f, 0.8f},
                             .alpha = 0.1f});
  Place(scene, Quad(4), floor, {0, 0, 0}, 10);
  Place(scene, Quad(1), 1, {0.3f, 0.5f, 0.2f}, 50);
  Place(scene, Sphere(0.4f, 6), 2, {-0.8f, 0.5f, 0.6f});
  Place(scene, Sphere(0.3f, 6), AddGlass(scene, 1.5f), {0.9f, 0.4f, 0.9f});
  scene.camera = LookAtCamera({0.4f, 2.1f, 3.5f}, {0, 0.2f, 0}, {0, 1, 0}, 60, false);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
  return scene;
}

}  // namespace skywave
