// A scene whose picture is a geometric series.
#pragma once

#include <cmath>

#include "scene/shapes/mesh.h"
#include "tests/support/render_scenes.h"

namespace skywave {

// The inside of a ball of radius 1 that emits and reflects uniformly: a surface receives the
// radiance that all others send. It is turned away from the axes.
inline constexpr float kCaveEmission = 0.5f;
inline const glm::vec3 kCaveAlbedo(0.8f, 0.5f, 0.2f);
inline Scene ShiningCave() {
  Scene scene;
  const std::uint32_t wall = AddLambert(scene, "wall", kCaveAlbedo);
  scene.materials[wall].emission = glm::vec3(kCaveEmission);
  Mesh cave = Facetted(Sphere(1, 16));
  FlipOrientation(cave);
  Place(scene, cave, wall, glm::vec3(0), 20);
  scene.camera = LookAtCamera({0.3f, 0.1f, -0.4f}, {0, 0, 1}, {0, 1, 0}, 70, false);
  return scene;
}

inline double CaveRadiance(int channel, std::uint32_t max_depth) {
  double sum = 0;
  for (std::uint32_t i = 0; i <= max_depth; ++i) {
    sum += kCaveEmission * std::pow(double(kCaveAlbedo[channel]), i);
  }
  return sum;
}

}  // namespace skywave
