// Draws texels by alias tables: of the whole map, of a cell picked by its energy, or of a given
// cell.
#pragma once

#include <vector>

#include "kernels/lights/texel_samplers.h"
#include "lights/tables/cells.h"
#include "lights/tables/search_tree.h"

namespace skywave {

// This is immutable. Inside a cell texels are drawn in proportion to importance[texel], and cells
// in proportion to the sum over their texels. Texels of kNoCell are never drawn.
class CellSampler {
 public:
  // `importance` has width * height values >= 0, in no cell all 0. `cells` is their number, at
  // least 1.
  CellSampler(int width, int height, const std::vector<double>& importance,
              const CellMap& cell_of_texel, std::uint32_t cells);

  std::uint32_t cells() const { return std::uint32_t(begin_.size() - 1); }
  std::size_t bytes() const;
  CellsView view() const;
  SearchTreeView tree() const { return tree_.view(); }
  // Returns 1 / probability of picking the cell.
  float Scale(std::uint32_t cell) const { return scale_[cell]; }
  // These return the density of every texel [1/sr] if a cell is picked by its energy, and if it is
  // given.
  const std::vector<float>& density() const { return density_; }
  std::vector<float> DensityInCells(const CellMap& cell_of_texel) const;

 private:
  std::vector<std::uint32_t> begin_, texel_;
  std::vector<AliasSlot> slots_;
  std::vector<float> density_, scale_;
  SearchTrees tree_;
};

}  // namespace skywave
