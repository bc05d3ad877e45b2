// Provides small operations on one Mesh, shared by the readers and the built-in scenes.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Moves the mesh by the affine `to`. Normals follow the inverse transpose; if `to` mirrors, the
// winding is swapped so that (p1 - p0) x (p2 - p0) stays on the side that the normals point to.
void TransformMesh(const glm::dmat4& to, Mesh& mesh);

// Returns the linear colour of a vertex for numbers in [0, 1] of sRGB, in which programs write them
// to OBJ and PLY. Others are clamped, and NaN is black.
glm::vec3 ColorOfSrgb(const glm::vec3& encoded);

// Swaps inside and outside by reversing winding and normals.
void FlipOrientation(Mesh& mesh);

// Gives every triangle three vertices of its own, with the coordinates (0, 0), (1, 0) and (1, 1),
// as pbrt does for meshes without any. The mesh has no colours and no tangents.
void GiveCornersUvs(Mesh& mesh);

// Winds every triangle so that its geometric normal is on the side of its vertex normals (if any).
void AlignWindingWithNormals(Mesh& mesh);

// Returns one unit normal per position: the mean of the adjacent triangles' normals weighted by
// area. Positions without a triangle of positive area get +z.
std::vector<glm::vec3> AreaWeightedNormals(const std::vector<glm::vec3>& positions,
                                           const std::vector<glm::uvec3>& triangles);

// Makes every normal unit length; normals of length zero are replaced by AreaWeightedNormals.
void NormalizeNormals(Mesh& mesh);

// Returns the first position that is NaN or infinite, or positions.size().
std::size_t FirstNonFinite(const std::vector<glm::vec3>& positions);

}  // namespace skywave
