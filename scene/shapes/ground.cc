#include "scene/shapes/ground.h"

#include <utility>

namespace skywave {

void AddGround(Scene& scene, const Bounds& bounds) {
  constexpr float kReflectance = 0.4f;
  constexpr float kReach = 100;  // half a side, in diagonals of the bounds
  constexpr float kGap = 1e-4f;  // in diagonals
  const glm::mat3 frame = EnvironmentFrame(scene.up_axis, scene.left_handed, 0);
  const glm::vec3 up = frame[2];
  float diagonal = glm::length(bounds.high - bounds.low);
  if (!(diagonal > 0)) diagonal = 1;
  const int axis = scene.up_axis - 'x';
  glm::vec3 centre = 0.5f * (bounds.low + bounds.high);
  centre[axis] = bounds.low[axis];
  centre -= kGap * diagonal * up;
  const glm::vec3 right = kReach * diagonal * frame[0], forward = kReach * diagonal * frame[1];

  Mesh mesh;
  mesh.name = "ground";
  mesh.positions = {centre - right - forward, centre + right - forward, centre + right + forward,
                    centre - right + forward};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  // In right-handed worlds right x forward is up, in left-handed ones it is down.
  if (scene.left_handed) {
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  }
  mesh.material = static_cast<std::uint32_t>(scene.materials.size());
  scene.materials.push_back({.name = "ground", .reflectance = glm::vec3(kReflectance)});
  scene.meshes.push_back(std::move(mesh));
}

}  // namespace skywave
