// Alpha and normal maps of the oracle, in double, at the image's own resolution.
#pragma once

#include "tests/support/oracle_texture.h"

namespace skywave {

inline double OracleMean(const glm::dvec3& v) { return (v.x + v.y + v.z) / 3; }

// Returns the fraction of rays that the material stops at uv.
inline double OracleOpacity(const Scene& scene, const Material& material, const glm::dvec2& uv) {
  double opacity = material.opacity;
  if (material.opacity_texture) {
    opacity *= OracleMean(LookUpTexture(scene, *material.opacity_texture, uv));
  }
  if (material.opacity_cutoff) return opacity >= *material.opacity_cutoff ? 1 : 0;
  return std::clamp(opacity, 0.0, 1.0);
}

// Applies a normal map to `n` (outer side) on a triangle. The axes point along increasing image
// coordinates, x rightwards and y upwards, made perpendicular to n.
inline glm::dvec3 OracleBend(const Scene& scene, const Material& material,
                             const glm::vec3 (&corner)[3], const glm::vec2 (&uv)[3],
                             const glm::dvec2& at, const glm::dvec3& n) {
  const Texture& texture = scene.textures[*material.normal_texture];
  const glm::dmat2 turn(glm::dmat3x2(texture.transform));
  const glm::dmat2 from_uv = turn * glm::dmat2(glm::dvec2(uv[1]) - glm::dvec2(uv[0]),
                                               glm::dvec2(uv[2]) - glm::dvec2(uv[0]));
  const glm::dvec3 e1 = glm::dvec3(corner[1]) - glm::dvec3(corner[0]),
                   e2 = glm::dvec3(corner[2]) - glm::dvec3(corner[0]);
  // The columns of the inverse express one step of the image's u and v in edges.
  const glm::dmat2 steps = glm::inverse(from_uv);
  const glm::dvec3 right = e1 * steps[0][0] + e2 * steps[0][1];
  const glm::dvec3 up = -(e1 * steps[1][0] + e2 * steps[1][1]);
  const glm::dvec3 x = glm::normalize(right - n * glm::dot(right, n));
  glm::dvec3 y = glm::cross(n, x);
  if (glm::dot(y, up) < 0) y = -y;
  glm::dvec3 seen = LookUpTexture(scene, *material.normal_texture, at) * 2.0 - 1.0;
  seen.x *= material.normal_scale, seen.y *= material.normal_scale;
  return glm::normalize(x * seen.x + y * seen.y + n * seen.z);
}

}  // namespace skywave
