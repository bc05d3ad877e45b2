// The trees of a two-dimensional inversion (kernels/environment.h) with their densities.
#pragma once

#include <vector>

#include "lights/search_tree.h"

namespace skywave {

class InversionTable {
 public:
  // Directions are drawn with the probability importance[row * width + column] over the sum, except
  // for a rounding that the density knows. importance >= 0, not all 0.
  InversionTable(std::uint32_t width, std::uint32_t height, const std::vector<double>& importance);

  InversionView view() const;
  std::size_t bytes() const {
    return rows_.bytes() + columns_.bytes() + block_density_.size() * sizeof(float);
  }

 private:
  SearchTrees rows_, columns_;
  std::vector<float> block_density_;  // [1/sr], height * blocks
};

}  // namespace skywave
