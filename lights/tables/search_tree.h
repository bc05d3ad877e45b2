// Builds the trees of cache lines that kernels/lights/environment.h searches.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/lights/environment.h"

namespace skywave {

// Holds `trees` distributions over `items` items each. They are allocated first, then each tree is
// set on its own, so that rows can be built in parallel.
class SearchTrees {
 public:
  SearchTrees(std::uint32_t items, std::uint32_t trees);

  // Sets tree `tree` from items() weights >= 0, not all zero unless the tree is never searched.
  // Masses are rounded to multiples of 1 / kNodeMass of their node, at least one where the weight
  // is positive; the result is written to
  //   leaf_mass[item]    mass in the leaf, 0..kNodeMass
  //   leaf[item / 32]    probability of the leaf over kNodeMass
  // so that the probability of an item is leaf * leaf_mass exactly as the search draws it.
  void Set(std::uint32_t tree, const double* weights, std::uint16_t* leaf_mass, double* leaf);

  std::uint32_t items() const { return items_; }
  std::uint32_t leaves() const { return (items_ + kNodeFan - 1) / kNodeFan; }
  std::size_t bytes() const;
  SearchTreeView view() const;

 private:
  std::uint32_t items_;
  std::uint32_t levels_;
  std::uint32_t nodes_[3] = {};  // per tree, root level first
  std::vector<SearchNode> level_[3];
};

}  // namespace skywave
