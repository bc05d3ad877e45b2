#include "wavefront/point_tree.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>

#include "kernels/columns.h"

namespace skywave {
namespace {

// Smaller ranges are built by one thread.
constexpr std::size_t kLeastParallel = 1 << 12;

struct Point {
  float at[3];
  std::uint32_t number;
};

std::uint32_t WidestAxis(std::span<const Point> points) {
  std::array<float, 3> low, high;
  low.fill(std::numeric_limits<float>::infinity());
  high.fill(-std::numeric_limits<float>::infinity());
  for (const Point& p : points) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p.at[axis]);
      high[axis] = std::max(high[axis], p.at[axis]);
    }
  }
  std::uint32_t widest = 0;
  for (std::uint32_t axis = 1; axis < 3; ++axis) {
    if (high[axis] - low[axis] > high[widest] - low[widest]) widest = axis;
  }
  return widest;
}

struct Builder {
  std::span<Point> points;
  std::span<PointTreeNode> nodes;
  std::uint32_t levels;

  std::size_t FirstOfLeaf(std::size_t leaf) const { return leaf * points.size() >> levels; }

  // The subtree of `node` over leaves [leaf, leaf + count). Points are ordered by coordinate and
  // number, no two alike, so the halves do not depend on how they are found.
  void Build(std::uint32_t node, std::size_t leaf, std::size_t count) const {
    const std::size_t begin = FirstOfLeaf(leaf), end = FirstOfLeaf(leaf + count);
    const std::span<Point> mine = points.subspan(begin, end - begin);
    if (count == 1) {
      std::sort(mine.begin(), mine.end(),
                [](const Point& a, const Point& b) { return a.number < b.number; });
      return;
    }
    const std::uint32_t axis = WidestAxis(mine);
    const auto middle = mine.begin() + std::ptrdiff_t(FirstOfLeaf(leaf + count / 2) - begin);
    std::nth_element(mine.begin(), middle, mine.end(), [axis](const Point& a, const Point& b) {
      return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.number < b.number;
    });
    nodes[node] = {.split = middle->at[axis], .axis = axis};
    const auto left = [&] { Build(2 * node, leaf, count / 2); };
    const auto right = [&] { Build(2 * node + 1, leaf + count / 2, count / 2); };
    if (mine.size() < kLeastParallel) {
      left(), right();
    } else {
      tbb::parallel_invoke(left, right);
    }
  }
};

// Levels of splits that bring `count` points down to kLeafPoints a leaf.
std::uint32_t LevelsFor(std::uint32_t count) {
  std::uint32_t levels = 0;
  while ((std::uint64_t(kLeafPoints) << levels) < count) ++levels;
  return levels;
}

}  // namespace

PointTree::PointTree(std::span<const float> x, std::span<const float> y, std::span<const float> z)
    : count_(std::uint32_t(x.size())), levels_(LevelsFor(count_)) {
  assert(x.size() == y.size() && x.size() == z.size() && x.size() < std::size_t{1} << 31);
  std::vector<Point> points(count_);
  const std::size_t stride = PaddedRows(count_);
  tbb::parallel_for(std::uint32_t{0}, count_, [&](std::uint32_t i) {
    points[i] = {.at = {x[i], y[i], z[i]}, .number = i};
  });
  nodes_.resize(std::size_t{1} << levels_);
  const Builder builder = {.points = points, .nodes = nodes_, .levels = levels_};
  if (count_ > 0) builder.Build(1, 0, std::size_t{1} << levels_);

  columns_.resize(3 * stride);
  order_.resize(count_);
  tbb::parallel_for(std::uint32_t{0}, count_, [&](std::uint32_t i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      columns_[axis * stride + i] = points[i].at[axis];
    }
    order_[i] = points[i].number;
  });
}

PointTreeView PointTree::view() const {
  const std::size_t stride = PaddedRows(count_);
  return {.nodes = nodes_.data(),
          .x = columns_.data(),
          .y = columns_.data() + stride,
          .z = columns_.data() + 2 * stride,
          .count = count_,
          .levels = levels_};
}

std::size_t PointTree::bytes() const {
  return nodes_.size() * sizeof(PointTreeNode) + columns_.size() * sizeof(float) +
         order_.size() * sizeof(std::uint32_t);
}

}  // namespace skywave
