// Points and lines as surfaces, which have no size of their own: spheres, and tubes with round
// ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Of the vertices of a mesh.
struct PointsAndLines {
  std::vector<std::uint32_t> points;
  std::vector<glm::uvec2> lines;
};

// Returns all vertices of a mesh as points.
PointsAndLines AllPoints(const Mesh& vertices);

// How finely points and lines are tessellated: as one sphere of 20 `frequency`^2 triangles for each
// point and end of a line, and one tube for each line.
struct PointTessellation {
  int frequency = 1;
  std::size_t triangles = 0;  // of all
};
// Returns the finest with about two million triangles in all; few points are smoother than many.
PointTessellation TessellationOf(const PointsAndLines& parts);

// Returns spheres and tubes of `diameter` at the positions of `vertices`, with their colours,
// alphas, coordinates of textures, name and material. Vertices that several parts share have one
// sphere. Throws InputError if they have more than `max_triangles`.
Mesh MakePoints(const Mesh& vertices, const PointsAndLines& parts, float diameter,
                std::size_t max_triangles, const std::string& path);

// Returns a diameter with which points nearly touch their nearest neighbours, on the median of a
// sample and rounded to one digit; 0.01 where that is no length.
float PointSizeFor(const std::vector<glm::vec3>& positions);

}  // namespace skywave
