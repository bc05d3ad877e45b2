// Computes normals of triangle corners for files that have none: smooth where the surface is
// smooth, with creases elsewhere.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace skywave {

// Faces that meet at a greater angle keep their edge if a file has no smoothing groups. The value
// lies between a cube's 90 degrees and the 45 of an octagonal column.
inline constexpr float kCreaseDegrees = 60;

// Corners shared by more triangles than this, as at the apex of a fan, keep the normal of their own
// triangle. This bounds the work on a file that attaches everything to one vertex.
inline constexpr std::size_t kMaxSmoothValence = 256;

// Returns three unit normals per triangle. A corner takes the mean of the triangles at its position
// that are smooth with its own: those of the same group if `groups` (one per triangle, 0: flat) are
// given, else those within kCreaseDegrees. Each is weighted by its angle there, so that the result
// does not depend on the diagonal along which a polygon was cut (Thuermer and Wuethrich 1998,
// "Computing Vertex Normals from Polygonal Facets"). Triangles without area get +z where they stand
// alone.
std::vector<glm::vec3> SmoothCornerNormals(const std::vector<glm::vec3>& positions,
                                           const std::vector<glm::uvec3>& triangles,
                                           std::span<const std::uint32_t> groups);

}  // namespace skywave
