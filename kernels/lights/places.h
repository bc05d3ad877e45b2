// Places are parts of the scene and of the directions of normals. A pilot learns which light
// arrives at each of them.
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

// Six octrees over a box, one for each axis and sign that a normal is closest to, lead to places.
// A node is a word: a leaf has the number of its place, all others have the index of the first of
// their eight children, which is the one with the least coordinates; x counts 1, y 2 and z 4.
inline constexpr std::uint32_t kPlaceLeaf = 1u << 31;
inline constexpr std::uint32_t kPlaceRoots = 6;    // +x, -x, +y, -y, +z, -z
inline constexpr std::uint32_t kPlaceLevels = 12;  // below a root, at most
struct PlaceTreeView {
  const std::uint32_t* nodes;  // the roots first
  float low[3];                // corner of the box
  float steps;                 // 2^kPlaceLevels / side of the box [1/length]
};

// Writes the place of each of surfaces [0, n) to place[row]. A place is below 2^24.
void FindPlaces(const PlaceTreeView& tree, std::uint32_t n, const SurfaceColumns& surfaces,
                float* place);

}  // namespace skywave
