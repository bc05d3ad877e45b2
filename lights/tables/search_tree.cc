#include "lights/tables/search_tree.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/large_memory.h"

namespace skywave {
namespace {

// Rounds weights to integer masses of a node's children: their starts go to the node, the masses to
// mass[k].
void FillNode(const double* weights, std::uint32_t count, SearchNode& node, std::uint32_t* mass) {
  double total = 0;
  for (std::uint32_t k = 0; k < count; ++k) total += weights[k];
  std::fill_n(mass, kNodeFan, 0u);
  if (total > 0) {
    std::int64_t sum = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      if (weights[k] <= 0) continue;
      mass[k] = std::max(1u, std::uint32_t(weights[k] / total * kNodeMass + 0.5));
      sum += mass[k];
    }
    // The largest child takes the rest of the rounding; it has at least 1 / 32 of the mass, far
    // more than 32 roundings can be off.
    std::uint32_t& largest = *std::max_element(mass, mass + kNodeFan);
    largest = std::uint32_t(std::int64_t(largest) + kNodeMass - sum);
  } else {
    mass[0] = kNodeMass;  // never reached: its parent gives it no mass
  }
  std::uint32_t start = 0;
  for (std::uint32_t k = 0; k < kNodeFan; ++k) {
    node.start[k] = std::int16_t(start);
    start += mass[k];
  }
  assert(start == kNodeMass);
}

}  // namespace

SearchTrees::SearchTrees(std::uint32_t items, std::uint32_t trees) : items_(items) {
  assert(items > 0 && items <= kNodeFan * kNodeFan * kNodeFan);
  levels_ = items <= kNodeFan ? 1 : items <= kNodeFan * kNodeFan ? 2 : 3;
  std::uint32_t width = items;
  for (std::uint32_t level = levels_; level-- > 0;) {
    width = (width + kNodeFan - 1) / kNodeFan;
    nodes_[level] = width;
    ResizeLarge(level_[level], std::size_t(width) * trees + 1);  // the padding starts with a 0
  }
}

void SearchTrees::Set(std::uint32_t tree, const double* weights, std::uint16_t* leaf_mass,
                      double* leaf) {
  // The weight of a node is the sum of its children's.
  std::vector<double> sums[4];
  sums[levels_].assign(weights, weights + items_);
  for (std::uint32_t level = levels_; level-- > 0;) {
    sums[level].assign(nodes_[level], 0.0);
    for (std::size_t child = 0; child < sums[level + 1].size(); ++child) {
      sums[level][child / kNodeFan] += sums[level + 1][child];
    }
  }
  // The probabilities of the nodes of a level follow from the integer masses above them.
  std::vector<double> probability = {1.0};
  std::uint32_t mass[kNodeFan];
  for (std::uint32_t level = 0; level < levels_; ++level) {
    const std::vector<double>& children = sums[level + 1];
    std::vector<double> next(children.size());
    for (std::uint32_t k = 0; k < nodes_[level]; ++k) {
      const std::uint32_t begin = k * kNodeFan;
      const auto count = std::min<std::uint32_t>(kNodeFan, std::uint32_t(children.size()) - begin);
      FillNode(&children[begin], count, level_[level][std::size_t(tree) * nodes_[level] + k], mass);
      for (std::uint32_t c = 0; c < count; ++c) {
        next[begin + c] = probability[k] * mass[c] / kNodeMass;
        if (level + 1 == levels_) leaf_mass[begin + c] = std::uint16_t(mass[c]);
      }
      if (level + 1 == levels_) leaf[k] = probability[k] / kNodeMass;
    }
    probability = std::move(next);
  }
}

std::size_t SearchTrees::bytes() const {
  std::size_t nodes = 0;
  for (const auto& level : level_) nodes += level.size();
  return nodes * sizeof(SearchNode);
}

SearchTreeView SearchTrees::view() const {
  SearchTreeView view = {.levels = levels_, .level = {}, .nodes = {}};
  for (std::uint32_t level = 0; level < levels_; ++level) {
    view.level[level] = level_[level].data();
    view.nodes[level] = nodes_[level];
  }
  return view;
}

}  // namespace skywave
