// Points near a point: a balanced k-d tree without pointers, and the searches in it.
//
// The tree is a heap of splits over 2^levels leaves; leaf i has points [i n / 2^levels,
// (i + 1) n / 2^levels), at most kLeafPoints. Points lie in the order of leaves, three columns, so
// a leaf is one or two vectors. The wavefront's PointTree (wavefront/photons/point_tree.h) builds
// it.
//
// Searches are exact: bounds of a cell are computed as distances are, and rounding is monotonous,
// so no cell is passed over that holds a point that counts. What they find, and in which order, is
// a function of tree and query alone, neither of the vector width nor of the batch.
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
  std::uint32_t levels = 0;                              // of splits
};

// What a search finds: a table of room rows that the caller gives, padded.
struct NeighborColumns {
  std::uint32_t* point;  // row of the tree's columns
  float* distance2;      // squared distance from the query

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.point), f(self.distance2);
  }
};

// Rows that a search for k points needs for each query: what it finds before it drops what is
// farther. A multiple of kPadRows.
constexpr std::uint32_t NearestRoom(std::uint32_t k) { return (2 * k + 6 * kLeafPoints) / 16 * 16; }

// The k points nearest to each of queries [0, n), of those nearer than the square root of
// radius2 (finite): count[i] rows of `found` from row i * NearestRoom(k) on, in no special order.
// Of points at the same distance as the k-th any may be taken. `found`: n * NearestRoom(k) rows.
void FindNearest(const PointTreeView& tree, const float* x, const float* y, const float* z,
                 std::uint32_t n, std::uint32_t k, float radius2, const NeighborColumns& found,
                 std::uint32_t* count);

// A search for everything within a radius, which may be more than there is room for: the cells that
// are still to be visited.
struct RangeSearch {
  struct Cell {
    std::uint32_t node;
    float offset[3];  // from the query to the cell, each axis
    float distance2;
  };
  float query[3];
  float radius2;
  std::uint32_t depth = 0;  // cells on the stack
  Cell stack[kMaxTreeLevels + 1];
};

RangeSearch StartRangeSearch(const PointTreeView& tree, const float query[3], float radius2);

// The next points nearer than the radius, at most `room` of them (>= 2 * kLeafPoints); returns
// their number, 0 at the end.
std::uint32_t FindMore(const PointTreeView& tree, RangeSearch& search, std::uint32_t room,
                       const NeighborColumns& found);

}  // namespace skywave
