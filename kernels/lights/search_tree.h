// Trees of cache lines by which discrete distributions are inverted.
#pragma once

#include <cstdint>

namespace skywave {

// A discrete distribution over n items is a tree of cache lines: a node holds where the masses of
// its 32 children start, as integers on a line of length kNodeMass, so a step of a search is one
// cache line, compared in one or two instructions, without a branch. There are 1, 2 or 3 levels for
// n up to 32, 1024 and 32768. Cumulation keeps the order of the items: the inversion is monotone.
inline constexpr std::uint32_t kNodeFan = 32;
inline constexpr std::uint32_t kNodeMass = 32767;  // the largest 16-bit signed integer
struct alignas(64) SearchNode {
  std::int16_t start[kNodeFan];  // start[0] = 0; a child without mass starts where the next does
};
struct SearchTreeView {
  std::uint32_t levels;
  const SearchNode* level[3];  // root level first; several trees follow each other
  std::uint32_t nodes[3];      // per tree in a level
};

}  // namespace skywave
