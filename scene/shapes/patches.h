// Surfaces over the unit square of (u, v) as meshes, with pbrt's parameters: dp/du x dp/dv points
// outside, uvs are the parameters. Round ones are cut every kPatchDegrees; that leaves the true
// circle by 1.5e-4 of the radius.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "scene/scene.h"

namespace skywave {

inline constexpr float kPatchDegrees = 2;

// About the z axis from angle 0 to `phi_degrees` (u); v runs from `low` to `high` in z.
// -radius <= low < high <= radius.
Mesh SpherePatch(float radius, float low, float high, float phi_degrees);
Mesh CylinderPatch(float radius, float low, float high, float phi_degrees);
// At z = height, normal +z; v runs from the outer to the inner circle.
Mesh DiskPatch(float radius, float inner_radius, float height, float phi_degrees);

// Corners of bilinear patches, four indices a patch: (u, v) = 00, 10, 01, 11. `normals` and `uvs`
// are empty or one a position.
struct BilinearCorners {
  std::span<const glm::vec3> positions, normals;
  std::span<const glm::vec2> uvs;
};
// A patch that is no parallelogram is cut into so many by so many.
inline constexpr int kBilinearSteps = 16;
// Adds one patch to `mesh`. Normals are those given or else the surface's own; uvs those given or
// else the parameters.
void AddBilinearPatch(const BilinearCorners& corners, const glm::uvec4& patch, Mesh& mesh);

}  // namespace skywave
