// These kernels draw directions by visibility that was learnt place by place: a place is a part of
// the scene and of the directions of normals, and has a distribution of its own over the cells of
// the map.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lights/environment.h"
#include "kernels/lights/texel_samplers.h"

namespace skywave {

// Six octrees over a box, one for each axis and sign that a normal is closest to, lead to places.
// A node is a word: a leaf has the number of its place, all others have the index of the first of
// their eight children, which is the one with the least coordinates; x counts 1, y 2 and z 4.
inline constexpr std::uint32_t kPlaceLeaf = 1u << 31;
inline constexpr std::uint32_t kPlaceRoots = 6;   // +x, -x, +y, -y, +z, -z
inline constexpr std::uint32_t kPlaceLevels = 12;  // below a root, at most
struct PlaceTreeView {
  const std::uint32_t* nodes;  // the roots first
  float low[3];                // corner of the box
  float steps;                 // 2^kPlaceLevels / side of the box [1/length]
};

// The distributions of places over `cells` cells: one tree of `trees` a place, and what it draws:
// probability[place * cells + cell].
struct PlacePicksView {
  SearchTreeView trees;
  const float* probability;
  std::uint32_t cells;
};

// Writes the place of each of surfaces [0, n) to light_norm. A place is below 2^24.
void FindPlaces(const PlaceTreeView& tree, std::uint32_t n, const SurfaceColumns& surfaces);

// Picks a cell for each of surfaces [0, n) by its place, which is in `light_norm`, and draws a
// texel of it. `cells.density` is that of each texel inside its cell [1/sr].
void SampleFromPlaces(const EnvironmentView& map, const CellsView& cells,
                      const PlacePicksView& picks, const float* light_norm,
                      const UniformColumns& uniforms, std::uint32_t n, float samples,
                      const LightColumns& out);

// Multiplies light_pdf of rows [0, n) by the probability of cell[i] at the place of surface
// from[i], which is in `light_norm`; rows without a density, whose pdf is 0, get anything.
void ScaleByPlace(const PlacePicksView& picks, const float* light_norm, const std::uint32_t* cell,
                  std::uint32_t n, const EscapeColumns& rows);

}  // namespace skywave
