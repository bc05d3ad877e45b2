// Normals of triangle corners for files that have none: smooth where the surface is, with creases
// where it is not.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace skywave {

// Faces that meet at a greater angle keep their edge where a file does not say where it is smooth.
// Between a cube's 90 degrees and the 45 of an octagonal column.
inline constexpr float kCreaseDegrees = 60;

// Corners of more triangles than this keep the normal of their own triangle: the apex of a fan. It
// bounds the work on a file that hangs everything on one vertex.
inline constexpr std::size_t kMaxSmoothValence = 256;

// Three unit normals a triangle. A corner takes the mean of the triangles at its position that are
// smooth with its own: those of the same group where `groups` (one a triangle, 0: flat) are given,
// else those within kCreaseDegrees. Each counts by its angle there, so that it does not matter
// along which diagonal a polygon was cut (Thuermer and Wuethrich 1998, "Computing Vertex Normals
// from Polygonal Facets"). Triangles without area get +z where they stand alone.
std::vector<glm::vec3> SmoothCornerNormals(const std::vector<glm::vec3>& positions,
                                           const std::vector<glm::uvec3>& triangles,
                                           std::span<const std::uint32_t> groups);

}  // namespace skywave
