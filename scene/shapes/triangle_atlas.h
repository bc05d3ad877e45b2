// An image of which each triangle of a mesh has a square of its own.
#pragma once

#include <cstddef>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// The texels [corner, corner + side) of the image, in x and y.
struct AtlasSquare {
  glm::ivec2 corner;
  int side;  // a power of two
};
struct TriangleAtlas {
  glm::ivec2 size{0};                // of the image [texels]; 0 if there are too many triangles
  std::vector<AtlasSquare> squares;  // one per triangle
};

// Gives triangles squares of 4 to 1024 texels a side, the more the longer their longest edge, so
// that the finest texels that fit have the same size everywhere. Their texels are `most` in sum,
// and those of the image less than twice as many.
TriangleAtlas MakeTriangleAtlas(const Mesh& mesh, std::size_t most);

// Gives each triangle three vertices, and places them in its square, with v upwards. They are
// centres of texels, so a bilinear lookup inside the triangle reads no other square; a coarser
// level of the image would (Texture::one_level).
void LayOutTriangles(const TriangleAtlas& atlas, Mesh& mesh);

}  // namespace skywave
