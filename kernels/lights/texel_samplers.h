// These kernels draw texels by other techniques than inversion: down a pyramid, and by alias
// tables.
#pragma once

#include <cstdint>

#include "kernels/lights/environment.h"

namespace skywave {

// Hierarchical warping (Clarberg et al. 2005) walks down a pyramid over the map, padded to powers
// of two. A level halves the region across (split_x), down (split_y) or both. It has one record per
// region of the level above.
struct WarpRecord {
  std::uint16_t top;          // share of the upper half, in units of 1 / kWarpOne
  std::uint16_t left_of_top;  // share of the left part of the upper half
  std::uint16_t left_of_bottom;
  std::uint16_t unused;
};
inline constexpr std::uint32_t kWarpOne = 65535;
struct WarpLevel {
  const WarpRecord* records;  // row-major
  std::uint32_t width;        // regions per row
  bool split_x, split_y;
};
inline constexpr std::uint32_t kMaxWarpLevels = 16;
struct WarpView {
  WarpLevel level[kMaxWarpLevels];  // coarsest first
  std::uint32_t levels;
};

// Fills rows [0, n) as SampleTexels does. `density` holds one value per texel [1/sr].
void SampleTexelsByWarp(const EnvironmentView& map, const WarpView& warp, const float* density,
                        const UniformColumns& uniforms, std::uint32_t n, float samples,
                        const LightColumns& out);

// Texels are grouped into cells with an alias table each (Walker 1977, Vose 1991): slot k of a cell
// keeps its own texel with probability `keep` and otherwise hands over to slot `other`. The map is
// not monotone: it costs well-distributed points their stratification inside the cell.
struct AliasSlot {
  float keep;
  std::uint32_t other;  // slot, counted through all cells
};
struct CellsView {
  const std::uint32_t* begin;  // first slot of a cell; cells + 1 entries
  const AliasSlot* slots;
  const std::uint32_t* texel;  // per slot
  const float* density;        // per texel of the map, if cells are picked by energy [1/sr]
};

// Picks a cell for each of rows [0, n) by `tree` at u, and a texel in it by the rest of u and by v.
// If `tree` is null, cell 0 holds all texels.
void SampleCells(const EnvironmentView& map, const CellsView& cells, const SearchTreeView* tree,
                 const UniformColumns& uniforms, std::uint32_t n, float samples,
                 const LightColumns& out);

// Draws a texel of cell `cell` for each row. `scale` is 1 / probability of the cell, which turns
// densities into those inside the cell.
void SampleOneCell(const EnvironmentView& map, const CellsView& cells, std::uint32_t cell,
                   float scale, const UniformColumns& uniforms, std::uint32_t n,
                   const LightColumns& out);

}  // namespace skywave
