// Many uniforms are searched at once in trees of cache lines (search_tree.h).
#if defined(SKYWAVE_KERNELS_SEARCH_TREE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_SEARCH_TREE_INL_H_
#undef SKYWAVE_KERNELS_SEARCH_TREE_INL_H_
#else
#define SKYWAVE_KERNELS_SEARCH_TREE_INL_H_
#endif

#include <algorithm>
#include <cstring>

#include "hwy/cache_control.h"
#include "kernels/lights/search_tree.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// These are the columns of the searches in flight. A chunk stays in the first-level cache.
constexpr std::uint32_t kChunk = 128;
struct SearchColumns {
  alignas(64) float x[kChunk];                // out: position inside the item found
  alignas(64) std::uint32_t item[kChunk];     // current node; out: item of its tree
  alignas(64) std::uint32_t limit[kChunk];    // position on the line of the node, rounded up
  alignas(64) std::uint32_t skipped[kChunk];  // children in front that nodes do not have
  alignas(64) std::uint32_t span[kChunk];     // start of the child, and of the next one << 16
};

// Counts the children that start below `limit`. A node is one cache line.
HWY_INLINE std::size_t CountStarts(const SearchNode& node, std::uint32_t limit) {
  const hn::CappedTag<std::int16_t, kNodeFan> d;
  const auto end = hn::Set(d, static_cast<std::int16_t>(limit));
  std::size_t count = 0;
  for (std::size_t i = 0; i < kNodeFan; i += hn::Lanes(d)) {
    count += hn::CountTrue(d, hn::Gt(end, hn::Load(d, node.start + i)));
  }
  return count;
}

// These return the start and the end of a child from its span. After the last child comes the start
// of another node, 0.
HWY_INLINE VU SpanStart(VU span) { return hn::And(span, SetU(0xFFFFu)); }
HWY_INLINE VU SpanEnd(VU span) {
  const VU next = hn::ShiftRight<16>(span);
  return IfThen(hn::Eq(next, SetU(0)), SetU(kNodeMass), next);
}

// Walks searches [0, n) of trees tree[i] at x[i] from node[i] down to a child. Writes its span and,
// as `item`, its number among the existing children: a tree leaves out `padding` of them at its
// end. Calls found(i, item) for each.
template <class Found>
HWY_INLINE void DescendLevel(const SearchNode* nodes, std::uint32_t padding,
                             const std::uint32_t* tree, const std::uint32_t* node, const float* x,
                             std::uint32_t n, SearchColumns& s, const Found& found) {
  const VF node_mass = Set(float(kNodeMass));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF scaled = Load(x + i) * node_mass;
    Store(scaled, s.x + i);
    // x < 1 stays so on the way down, but whatever it is, the search stays in the node.
    const VU target = hn::Min(ToUnsigned(scaled), SetU(kNodeMass - 1));
    Store(target + SetU(1), s.limit + i);
    Store(Load(tree + i) * SetU(padding), s.skipped + i);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const SearchNode& here = nodes[node[i]];
    const std::size_t child = CountStarts(here, s.limit[i]) - 1;
    std::memcpy(&s.span[i], &here.start[child], sizeof s.span[i]);
    s.item[i] = node[i] * kNodeFan + std::uint32_t(child) - s.skipped[i];
    found(i, s.item[i]);
  }
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU span = Load(s.span + i);
    const VF start = ToFloat(SpanStart(span)), end = ToFloat(SpanEnd(span));
    Store((Load(s.x + i) - start) / (end - start), s.x + i);
  }
}

// This is the tree of every search if there is only one.
alignas(64) inline constexpr std::uint32_t kFirstTree[kChunk] = {};

// Searches tree[i] at x[i] in [0, 1), and calls found(i, item) as soon as an item is known, which
// is the time to prefetch its data. The nodes of a level are numbered across all trees, so the
// child numbers of one level, less the padding of the trees in front, are node numbers of the next.
template <class Found>
HWY_INLINE void Search(const SearchTreeView& trees, const std::uint32_t* tree, const float* x,
                       std::uint32_t n, SearchColumns& s, const Found& found) {
  const std::uint32_t* node = tree;  // a tree has one root
  const std::uint32_t last = trees.levels - 1;
  for (std::uint32_t level = 0; level < last; ++level) {
    const SearchNode* const below = trees.level[level + 1];
    const std::uint32_t padding = trees.nodes[level] * kNodeFan - trees.nodes[level + 1];
    DescendLevel(trees.level[level], padding, tree, node, x, n, s,
                 [&](std::uint32_t, std::uint32_t next) { hwy::Prefetch(below + next); });
    node = s.item, x = s.x;
  }
  const std::uint32_t all = trees.nodes[last] * kNodeFan;
  DescendLevel(trees.level[last], all, tree, node, x, n, s, found);
}
HWY_INLINE void Search(const SearchTreeView& tree, const float* x, std::uint32_t n,
                       SearchColumns& s) {
  Search(tree, kFirstTree, x, n, s, [](std::uint32_t, std::uint32_t) {});
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
