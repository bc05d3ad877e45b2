// Draws texels by alias tables: of the whole map, of a cell picked by its energy, or of a given
// cell.
#pragma once

#include <vector>

#include "kernels/lights/texel_samplers.h"
#include "lights/tables/cells.h"
#include "lights/tables/search_tree.h"

namespace skywave {

// Immutable. Inside a cell texels are drawn in proportion to importance[texel]; a cell in
// proportion to the sum over its texels. Texels of kNoCell are never drawn.
class CellSampler {
 public:
  // importance: width * height values >= 0, a cell's not all 0. cells: their number, at least 1.
  CellSampler(int width, int height, const std::vector<double>& importance,
              const CellMap& cell_of_texel, std::uint32_t cells);

  std::uint32_t cells() const { return std::uint32_t(begin_.size() - 1); }
  std::size_t bytes() const;
  CellsView view() const;
  SearchTreeView tree() const { return tree_.view(); }
  // 1 / probability of picking the cell.
  float Scale(std::uint32_t cell) const { return scale_[cell]; }
  // Density of every texel where a cell is picked by its energy, and where it is given [1/sr].
  const std::vector<float>& density() const { return density_; }
  std::vector<float> DensityInCells(const CellMap& cell_of_texel) const;

 private:
  std::vector<std::uint32_t> begin_, texel_;
  std::vector<AliasSlot> slots_;
  std::vector<float> density_, scale_;
  SearchTrees tree_;
};

}  // namespace skywave
