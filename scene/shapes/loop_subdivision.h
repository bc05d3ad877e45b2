// Loop subdivision of a triangle cage, with vertices and exact normals on the limit surface.
//
// Rules: Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987, with Warren's weights (beta
// = 3/16 at valence 3, else 3/(8n)), and cubic B-spline curves along boundaries. Limit positions
// and tangents: Hoppe et al., "Piecewise Smooth Surface Reconstruction", 1994, Section 4 and its
// appendix.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Readers allow no more: the edges of this many triangles take about 2 GB during subdivision.
inline constexpr std::size_t kMaxSubdividedTriangles = std::size_t{1} << 24;

// Each of `levels` >= 0 steps splits every triangle into four; the vertices are then moved to the
// limit surface and get its unit normals. `triangles` index into `positions`; positions that no
// triangle uses are kept in place. Fills positions, normals and triangles of the result. Triangles
// keep their order (the four children together) and orientation.
//
// Edges with one triangle, and non-manifold ones with more than two, are boundaries: they converge
// to the curve of their own vertices. A vertex at which the number of boundary edges is not two is
// a corner and stays. Time and memory are linear in the number of resulting triangles.
Mesh LoopSubdivide(const std::vector<glm::vec3>& positions,
                   const std::vector<glm::uvec3>& triangles, int levels);

}  // namespace skywave
