// Tessellates surfaces over the unit square of (u, v), with pbrt's parameters: dp/du x dp/dv points
// outside, and uvs are the parameters. Round surfaces are cut every kPatchDegrees, which deviates
// from the true circle by 1.5e-4 of the radius.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <span>

#include "scene/scene.h"

namespace skywave {

inline constexpr float kPatchDegrees = 2;

struct SurfacePoint {
  glm::dvec3 position, normal;  // the normal may have any length
  glm::dvec2 uv;
};
// A surface over (u, v) in the unit square.
using PatchSurface = std::function<SurfacePoint(double u, double v)>;
// Adds columns x rows quads of a surface to `mesh`. Triangles with two coincident corners, as at
// poles, are left out.
void AddPatch(int columns, int rows, const PatchSurface& surface, Mesh& mesh);

// u runs about the z axis from angle 0 to `phi_degrees`, v from `low` to `high` in z. -radius <=
// low < high <= radius.
Mesh SpherePatch(float radius, float low, float high, float phi_degrees);
Mesh CylinderPatch(float radius, float low, float high, float phi_degrees);
// These have v from the rim at z = 0 to the apex at `height`; from `low` to `high` in z, 0 <= low <
// high, of which `radius` is that at `high`; and along the line from p1 to p2, which is revolved.
Mesh ConePatch(float radius, float height, float phi_degrees);
Mesh ParaboloidPatch(float radius, float low, float high, float phi_degrees);
Mesh HyperboloidPatch(const glm::dvec3& p1, const glm::dvec3& p2, float phi_degrees);
// The disk lies at z = height with normal +z; v runs from the outer to the inner circle.
Mesh DiskPatch(float radius, float inner_radius, float height, float phi_degrees);

// Corners of bilinear patches, four indices per patch: (u, v) = 00, 10, 01, 11. `normals` and `uvs`
// are empty or have one entry per position.
struct BilinearCorners {
  std::span<const glm::vec3> positions, normals;
  std::span<const glm::vec2> uvs;
};
// A patch that is not a parallelogram is cut into this many cells along u and along v.
inline constexpr int kBilinearSteps = 16;
// Adds one patch to `mesh`. Normals and uvs are those given, or else the surface's own normals and
// the parameters.
void AddBilinearPatch(const BilinearCorners& corners, const glm::uvec4& patch, Mesh& mesh);

}  // namespace skywave
