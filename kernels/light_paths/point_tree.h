// A balanced k-d tree without pointers finds the points near a point.
//
// The tree is a heap of splits over 2^levels leaves; leaf i has points [i n / 2^levels, (i + 1) n /
// 2^levels), at most kLeafPoints. Points lie in the order of leaves in three columns, so a leaf is
// one or two vectors. The wavefront's PointTree (wavefront/records/point_tree.h) builds it.
//
// Searches are exact: bounds of a cell are computed as distances are, and rounding is monotonic, so
// no cell that holds a point in reach is passed over. The points found and their order are a
// function of tree and query alone, neither of the vector width nor of the batch.
#pragma once

#include <cstdint>

namespace skywave {

inline constexpr std::uint32_t kLeafPoints = 16;
inline constexpr std::uint32_t kMaxTreeLevels = 28;

// Points of the left child have coordinates <= split, those of the right one >= split.
struct PointTreeNode {
  float split;
  std::uint32_t axis;  // 0 to 2
};

struct PointTreeView {
  const PointTreeNode* nodes = nullptr;  // children of node i: 2 i and 2 i + 1; the root is 1
  const float *x = nullptr, *y = nullptr, *z = nullptr;  // PaddedRows(count) each
  std::uint32_t count = 0;                               // points, below 2^31
  std::uint32_t levels = 0;                              // levels of splits
};

// A search writes what it finds to a padded table that the caller provides.
struct NeighborColumns {
  std::uint32_t* point;  // row of the tree's columns
  float* distance2;      // squared distance from the query

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.point), f(self.distance2);
  }
};

// Returns the rows that a search for k points needs for each query: it finds more before it drops
// the farthest. The number is a multiple of kPadRows.
constexpr std::uint32_t NearestRoom(std::uint32_t k) { return (2 * k + 6 * kLeafPoints) / 16 * 16; }

// Finds the k points nearest to each of queries [0, n) among those nearer than the square root of
// radius2 (finite): writes count[i] rows of `found` from row i * NearestRoom(k) on, in no special
// order. Any points at the same distance as the k-th may be taken. `found` has n * NearestRoom(k)
// rows.
void FindNearest(const PointTreeView& tree, const float* x, const float* y, const float* z,
                 std::uint32_t n, std::uint32_t k, float radius2, const NeighborColumns& found,
                 std::uint32_t* count);

// A search for all points within a radius, which may be more than there is room for, keeps the
// cells that are still to be visited.
struct RangeSearch {
  struct Cell {
    std::uint32_t node;
    float offset[3];  // from the query to the cell, per axis
    float distance2;
  };
  float query[3];
  float radius2;
  std::uint32_t depth = 0;  // cells on the stack
  Cell stack[kMaxTreeLevels + 1];
};

RangeSearch StartRangeSearch(const PointTreeView& tree, const float query[3], float radius2);

// Finds the next points nearer than the radius, at most `room` of them (>= 2 * kLeafPoints);
// returns their number, 0 at the end.
std::uint32_t FindMore(const PointTreeView& tree, RangeSearch& search, std::uint32_t room,
                       const NeighborColumns& found);

}  // namespace skywave
