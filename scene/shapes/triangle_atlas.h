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
  glm::ivec2 size{0};  // of the image [texels]; 0 if there are no triangles, or too many
  std::vector<AtlasSquare> squares;  // one per triangle
};

// Gives each triangle a square of 4 to 1024 texels a side, in proportion to its longest edge but
// for rounding up to a power of two. The scale is the finest at which all squares together have at
// most `most` texels; the image has less than twice as many as they. Positions are finite.
TriangleAtlas MakeTriangleAtlas(const Mesh& mesh, std::size_t most);

// Gives each triangle of the atlas's mesh three vertices of its own, and (u, v) in its square, with
// v upwards. Corners lie at centres of texels, so a bilinear lookup inside the triangle reads no
// other square; a coarser level of the image would (Texture::one_level).
void LayOutTriangles(const TriangleAtlas& atlas, Mesh& mesh);

}  // namespace skywave
