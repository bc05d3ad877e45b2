// Builds the tree of kernels/point_tree.h and owns it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/point_tree.h"

namespace skywave {

class PointTree {
 public:
  PointTree() = default;
  // Of points (x[i], y[i], z[i]), finite, fewer than 2^31. Runs on the threads of the arena of the
  // caller; the tree is the same for any number of them. Needs 16 bytes a point while it builds.
  PointTree(std::span<const float> x, std::span<const float> y, std::span<const float> z);

  PointTreeView view() const;
  // The number of the point, in the order in which points were given, of each row of the tree.
  std::span<const std::uint32_t> order() const { return order_; }
  // What the tree keeps.
  std::size_t bytes() const;

 private:
  std::uint32_t count_ = 0, levels_ = 0;
  std::vector<PointTreeNode> nodes_;
  std::vector<float> columns_;  // x, y, z, PaddedRows(count_) each
  std::vector<std::uint32_t> order_;
};

}  // namespace skywave
