// The normal that surface preparation and normal maps give to a place on a triangle.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "kernels/surface/normal_map.h"
#include "kernels/surface/surface.h"
#include "scene/geometry.h"
#include "wavefront/soa.h"

namespace skywave {

// Returns the shading normal of a triangle of the world, which is opaque, at the barycentric
// coordinates `place` of its second and third corner, as seen from `wo` with textures at their
// finest.
inline glm::vec3 BentNormal(const Geometry& geometry, const Mesh& mesh, std::uint32_t triangle,
                            const glm::vec2& place, const glm::vec3& wo) {
  const soa::Table<SurfaceColumns> table(1);
  const SurfaceColumns& s = table;
  const glm::uvec3& t = mesh.triangles[triangle];
  const glm::vec3 ng = glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                  mesh.positions[t.z] - mesh.positions[t.x]);
  s.ng_x[0] = ng.x, s.ng_y[0] = ng.y, s.ng_z[0] = ng.z;
  s.wo_x[0] = wo.x, s.wo_y[0] = wo.y, s.wo_z[0] = wo.z;
  s.u[0] = place.x, s.v[0] = place.y, s.t[0] = 1, s.triangle[0] = triangle;
  PrepareSurfaces(geometry.triangle_tables(), geometry.materials().records, 1, s);
  BendNormals(geometry.textures(), geometry.normal_maps(), 0, 1, s);
  return {s.ns_x[0], s.ns_y[0], s.ns_z[0]};
}

}  // namespace skywave
