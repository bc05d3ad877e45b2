#include "kernels/light_paths/point_tree.h"

#include <bit>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/point_tree.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// This list of neighbors grows leaf by leaf.
struct Found {
  NeighborColumns rows;
  std::uint32_t size;
};

// Appends the points of a leaf that are nearer than the radius.
HWY_INLINE void ScanLeaf(const PointTreeView& tree, std::uint32_t leaf, const float* query,
                         float radius2, Found& found) {
  const auto begin = std::uint32_t(std::uint64_t(leaf) * tree.count >> tree.levels);
  const auto end = std::uint32_t(std::uint64_t(leaf + 1) * tree.count >> tree.levels);
  const V3 q = Set3(query);
  for (std::uint32_t i = begin; i < end; i += hn::Lanes(F())) {
    const V3 offset = Load3(tree.x + i, tree.y + i, tree.z + i) - q;
    const VF distance2 = Dot(offset, offset);
    const MU near = hn::RebindMask(U(), hn::Lt(distance2, Set(radius2)));
    const RowCompressor append(hn::And(near, RowsBelow(i, end)));
    if (append.count() == 0) continue;
    append.Append(distance2, found.rows.distance2 + found.size);
    append.Append(hn::Iota(U(), i), found.rows.point + found.size);
    found.size += append.count();
  }
}

HWY_INLINE float Length2(const float* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

// Descends from the top of the stack to the nearest leaf below it and leaves the cells that it
// passes on the stack, if they are near enough. Returns the leaf, or kNoLeaf if nothing is left.
constexpr std::uint32_t kNoLeaf = 0xFFFFFFFFu;
HWY_INLINE std::uint32_t NextLeaf(const PointTreeView& tree, float radius2, RangeSearch& s) {
  const std::uint32_t first_leaf = 1u << tree.levels;
  while (s.depth > 0) {
    RangeSearch::Cell cell = s.stack[--s.depth];
    if (cell.distance2 >= radius2) continue;
    while (cell.node < first_leaf) {
      const PointTreeNode& node = tree.nodes[cell.node];
      const float delta = s.query[node.axis] - node.split;
      const std::uint32_t near = 2 * cell.node + (delta >= 0);
      RangeSearch::Cell& far = s.stack[s.depth];
      far = cell;
      far.node = near ^ 1;
      far.offset[node.axis] = delta;
      far.distance2 = Length2(far.offset);
      s.depth += far.distance2 < radius2;
      cell.node = near;
    }
    return cell.node - first_leaf;
  }
  return kNoLeaf;
}

HWY_INLINE std::uint32_t CountNearer(const Found& found, float radius2) {
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < found.size; i += hn::Lanes(F())) {
    const MF nearer = hn::Lt(Load(found.rows.distance2 + i), Set(radius2));
    count += std::uint32_t(
        hn::CountTrue(U(), hn::And(hn::RebindMask(U(), nearer), RowsBelow(i, found.size))));
  }
  return count;
}

HWY_INLINE float Farthest2(const Found& found) {
  VF farthest = hn::Zero(F());
  for (std::uint32_t i = 0; i < found.size; i += hn::Lanes(F())) {
    const MF inside = hn::RebindMask(F(), RowsBelow(i, found.size));
    farthest = hn::Max(farthest, hn::IfThenElseZero(inside, Load(found.rows.distance2 + i)));
  }
  return hn::GetLane(hn::MaxOfLanes(F(), farthest));
}

// Keeps the points that are nearer than radius2, and the first `ties` of those exactly there.
HWY_INLINE void KeepNearer(float radius2, std::uint32_t ties, Found& found) {
  std::uint32_t kept = 0;
  const NeighborColumns& rows = found.rows;
  if (ties > 0) {
    for (std::uint32_t i = 0; i < found.size; ++i) {
      if (rows.distance2[i] > radius2) continue;
      if (rows.distance2[i] == radius2 && ties-- == 0) {
        ++ties;
        continue;
      }
      rows.distance2[kept] = rows.distance2[i];
      rows.point[kept++] = rows.point[i];
    }
  } else {
    for (std::uint32_t i = 0; i < found.size; i += hn::Lanes(F())) {
      const VF distance2 = Load(rows.distance2 + i);
      const VU point = Load(rows.point + i);
      const MU nearer = hn::RebindMask(U(), hn::Lt(distance2, Set(radius2)));
      const RowCompressor append(hn::And(nearer, RowsBelow(i, found.size)));
      append.Append(distance2, rows.distance2 + kept);
      append.Append(point, rows.point + kept);
      kept += append.count();
    }
  }
  found.size = kept;
}

// Drops the farthest of more than k points, so that k to k + slack are left; returns a radius2 that
// all of those are below. Squared distances of points on a surface are spread uniformly, so
// interpolation finds the radius in a few steps; halving the bits is for the rest.
HWY_INLINE float DropFar(std::uint32_t k, std::uint32_t slack, Found& found) {
  constexpr int kInterpolations = 5;
  const auto bits = [](float v) { return std::bit_cast<std::uint32_t>(v); };
  float low = 0, high = std::bit_cast<float>(bits(Farthest2(found)) + 1);
  std::uint32_t below_low = 0, below_high = found.size;
  for (int step = 0; below_high > k + slack; ++step) {
    if (bits(high) - bits(low) <= 1) {
      KeepNearer(low, k - below_low, found);
      return high;
    }
    float radius2 = std::bit_cast<float>(bits(low) + (bits(high) - bits(low)) / 2);
    if (step < kInterpolations) {
      const float share = (float(k - below_low) + 0.5f * float(slack) + 0.5f) /
                          (float(below_high - below_low) + 1.0f);
      const float guess = low + (high - low) * share;
      if (guess > low && guess < high) radius2 = guess;
    }
    const std::uint32_t below = CountNearer(found, radius2);
    if (below < k) {
      low = radius2, below_low = below;
    } else {
      high = radius2, below_high = below;
    }
  }
  if (below_high < found.size) KeepNearer(high, 0, found);
  return high;
}

void FindNearest(const PointTreeView& tree, const float* x, const float* y, const float* z,
                 std::uint32_t n, std::uint32_t k, float radius2, const NeighborColumns& table,
                 std::uint32_t* count) {
  const std::uint32_t room = NearestRoom(k);
  // Above this size another leaf might not fit.
  const std::uint32_t full = room - kLeafPoints;
  for (std::uint32_t i = 0; i < n; ++i) {
    Found found = {.rows = Slice(table, i * room), .size = 0};
    const float query[3] = {x[i], y[i], z[i]};
    RangeSearch search = skywave::StartRangeSearch(tree, query, radius2);
    float limit2 = radius2;
    for (;;) {
      const std::uint32_t leaf = NextLeaf(tree, limit2, search);
      if (leaf == kNoLeaf) break;
      ScanLeaf(tree, leaf, query, limit2, found);
      if (found.size > full) limit2 = DropFar(k, k / 4, found);
    }
    if (found.size > k) DropFar(k, 0, found);
    count[i] = found.size;
  }
}

std::uint32_t FindMore(const PointTreeView& tree, RangeSearch& search, std::uint32_t room,
                       const NeighborColumns& table) {
  Found found = {.rows = table, .size = 0};
  while (found.size + kLeafPoints <= room) {
    const std::uint32_t leaf = NextLeaf(tree, search.radius2, search);
    if (leaf == kNoLeaf) break;
    ScanLeaf(tree, leaf, search.query, search.radius2, found);
  }
  return found.size;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(FindNearest);
HWY_EXPORT(FindMore);

RangeSearch StartRangeSearch(const PointTreeView& tree, const float query[3], float radius2) {
  RangeSearch search;
  for (int axis = 0; axis < 3; ++axis) search.query[axis] = query[axis];
  search.radius2 = radius2;
  if (tree.count > 0) {
    search.stack[0] = {.node = 1, .offset = {0, 0, 0}, .distance2 = 0};
    search.depth = 1;
  }
  return search;
}

void FindNearest(const PointTreeView& tree, const float* x, const float* y, const float* z,
                 std::uint32_t n, std::uint32_t k, float radius2, const NeighborColumns& found,
                 std::uint32_t* count) {
  HWY_DYNAMIC_DISPATCH(FindNearest)(tree, x, y, z, n, k, radius2, found, count);
}

std::uint32_t FindMore(const PointTreeView& tree, RangeSearch& search, std::uint32_t room,
                       const NeighborColumns& found) {
  return HWY_DYNAMIC_DISPATCH(FindMore)(tree, search, room, found);
}

}  // namespace skywave
#endif  // HWY_ONCE
