// Builds the tree of kernels/light_paths/point_tree.h and owns it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/light_paths/point_tree.h"
#include "wavefront/soa.h"

namespace skywave {

// The tree is built of such points.
struct TreePoint {
  float at[3];           // finite
  std::uint32_t number;  // no two alike
};

// One row is one point, in the order of leaves.
struct TreeRowColumns {
  float *x, *y, *z;
  std::uint32_t* number;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.x), f(self.y), f(self.z), f(self.number);
  }
};

class PointTree {
 public:
  PointTree() = default;
  // Builds a tree of fewer than 2^31 points, whose order is lost. Runs on the threads of the
  // caller's arena; the tree depends on neither their number nor the order of the points.
  explicit PointTree(std::span<TreePoint> points);

  PointTreeView view() const;
  // Returns the number of the point of each row of the tree.
  std::span<const std::uint32_t> order() const { return {rows_->number, count_}; }
  // Returns the memory that the tree keeps.
  std::size_t bytes() const;

 private:
  std::uint32_t count_ = 0, levels_ = 0;
  std::vector<PointTreeNode> nodes_;
  soa::Table<TreeRowColumns> rows_;
};

}  // namespace skywave
