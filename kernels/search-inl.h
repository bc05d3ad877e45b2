// Searches of many uniforms at once in trees of cache lines (SearchTreeView in environment.h).
#if defined(SKYWAVE_KERNELS_SEARCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_SEARCH_INL_H_
#undef SKYWAVE_KERNELS_SEARCH_INL_H_
#else
#define SKYWAVE_KERNELS_SEARCH_INL_H_
#endif

#include <algorithm>
#include <cstring>

#include "hwy/cache_control.h"
#include "kernels/environment.h"
#include "kernels/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Columns of a search in flight. A chunk stays in the first-level cache.
constexpr std::uint32_t kChunk = 128;
struct SearchColumns {
  alignas(64) float x[kChunk];               // in: uniform; out: position inside the item found
  alignas(64) std::uint32_t item[kChunk];    // in: tree; out: item, counted through all trees
  alignas(64) std::uint32_t target[kChunk];  // position on the line of the node
  alignas(64) std::uint32_t span[kChunk];    // start of the child, and of the next one << 16
  alignas(64) float mass[kChunk];  // out: product of the masses on the way, of kNodeMass a level
};

// The last child that does not start behind `target`. A node is one cache line.
HWY_INLINE std::uint32_t FindChild(const SearchNode& node, std::uint32_t target) {
  const hn::CappedTag<std::int16_t, kNodeFan> d;
  const auto limit = hn::Set(d, static_cast<std::int16_t>(target));
  std::size_t behind = 0;
  for (std::size_t i = 0; i < kNodeFan; i += hn::Lanes(d)) {
    behind += hn::CountTrue(d, hn::Gt(hn::Load(d, node.start + i), limit));
  }
  return kNodeFan - 1 - static_cast<std::uint32_t>(behind);
}

// Start and end of a child from its span. Behind the last child stands the start of another node,
// 0.
HWY_INLINE VU SpanStart(VU span) { return hn::And(span, SetU(0xFFFFu)); }
HWY_INLINE VU SpanEnd(VU span) {
  const VU next = hn::ShiftRight<16>(span);
  return IfThen(hn::Eq(next, SetU(0)), SetU(kNodeMass), next);
}

// Walks `n` searches down a level: `item` is the node on the way in and the child on the way out.
HWY_INLINE void DescendLevel(const SearchNode* nodes, std::uint32_t n, SearchColumns& s) {
  const VF node_mass = Set(float(kNodeMass));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF scaled = hn::Mul(Load(s.x + i), node_mass);
    Store(scaled, s.x + i);
    Store(ToUnsigned(scaled), s.target + i);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const SearchNode& node = nodes[s.item[i]];
    const std::uint32_t child = FindChild(node, s.target[i]);
    std::memcpy(&s.span[i], &node.start[child], sizeof s.span[i]);
    s.item[i] = s.item[i] * kNodeFan + child;
  }
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU span = Load(s.span + i);
    const VF start = ToFloat(SpanStart(span)), end = ToFloat(SpanEnd(span));
    const VF mass = hn::Sub(end, start);
    Store(hn::Div(hn::Sub(Load(s.x + i), start), mass), s.x + i);
    Store(hn::Mul(Load(s.mass + i), mass), s.mass + i);
  }
}

// Searches the tree whose number stands in `item`. Afterwards the span is that of the item in its
// leaf. A level's nodes are numbered through all trees, so that the child numbers of one level,
// less what the padding of the level above skips, are node numbers of the next.
HWY_INLINE void Search(const SearchTreeView& trees, std::uint32_t n, SearchColumns& s) {
  alignas(64) std::uint32_t tree[kChunk];
  std::copy_n(s.item, n, tree);
  std::fill_n(s.mass, n, 1.0f);
  for (std::uint32_t level = 0; level < trees.levels; ++level) {
    if (level > 0) {
      // Child c of node (tree, k) is node tree * nodes + (k * fan + c) of the next level.
      const std::uint32_t above = trees.nodes[level - 1] * kNodeFan, here = trees.nodes[level];
      for (std::uint32_t i = 0; i < n; ++i) {
        s.item[i] -= tree[i] * (above - here);
        hwy::Prefetch(trees.level[level] + s.item[i]);
      }
    }
    DescendLevel(trees.level[level], n, s);
  }
  const std::uint32_t slots = trees.nodes[trees.levels - 1] * kNodeFan;
  for (std::uint32_t i = 0; i < n; ++i) s.item[i] -= tree[i] * slots;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
