#include "lights/tables/places.h"

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

constexpr std::uint32_t kPositionShift = kPlaceWordShift + kPlaceWordFree;
constexpr std::uint32_t kRootShift = kPositionShift + 3 * kPlaceLevels;
static_assert(kRootShift + 3 == 64);
constexpr double kNormalSteps = 127;

// Returns the bits of a coordinate, two zeros before each.
std::uint64_t Spread(std::uint32_t steps) {
  std::uint64_t spread = 0;
  for (std::uint32_t bit = 0; bit < kPlaceLevels; ++bit) {
    spread |= std::uint64_t(steps >> bit & 1) << (3 * bit);
  }
  return spread;
}

}  // namespace

std::array<double, 3> MeanNormal(std::span<const PlaceWord> words) {
  std::int64_t sums[3] = {};
  for (const PlaceWord word : words) {
    const auto root = std::uint32_t(word >> kRootShift), axis = root / 2;
    const auto a = std::int8_t(word & 0xFF), b = std::int8_t(word >> 8 & 0xFF);
    const double square = kNormalSteps * kNormalSteps - double(a) * a - double(b) * b;
    const std::int64_t along = std::llrint(std::sqrt(std::max(square, 0.0)));
    sums[axis] += root % 2 == 0 ? along : -along;
    sums[(axis + 1) % 3] += a, sums[(axis + 2) % 3] += b;
  }
  const double scale = 1 / (kNormalSteps * double(std::max<std::size_t>(words.size(), 1)));
  return {double(sums[0]) * scale, double(sums[1]) * scale, double(sums[2]) * scale};
}

PlaceWord PackPlace(const PlaceBox& box, const std::array<float, 3>& org,
                    const std::array<float, 3>& normal) {
  constexpr float kSteps = 1 << kPlaceLevels;
  std::uint64_t position = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const float steps = (org[i] - box.low[i]) * (kSteps / box.side);
    position |= Spread(std::uint32_t(std::clamp(steps, 0.0f, kSteps - 1))) << i;
  }
  const float x = std::fabs(normal[0]), y = std::fabs(normal[1]), z = std::fabs(normal[2]);
  const std::size_t axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
  const std::uint64_t root = 2 * axis + (normal[axis] < 0);
  const auto across = [&](std::size_t i) {
    const double steps = kNormalSteps * double(normal[(axis + i) % 3]);
    return std::uint64_t(std::uint8_t(std::int8_t(std::clamp(std::round(steps), -127.0, 127.0))));
  };
  return root << kRootShift | position << kPositionShift | across(2) << 8 | across(1);
}

void PlaceTree::Renumber(std::span<const std::uint32_t> place) {
  for (std::uint32_t& word : words) {
    if (word >= kPlaceLeaf) word = kPlaceLeaf | place[word - kPlaceLeaf];
  }
}

PlaceTree BuildPlaceTree(std::span<const PlaceWord> sorted, const PlaceBox& box, std::size_t split,
                         std::size_t most) {
  // Nodes that may be split are on a heap, the largest on top.
  struct Open {
    std::size_t begin, end;
    std::uint32_t node, word;  // its indices
    std::uint32_t level;       // below a root
    std::uint64_t key;         // root and position, the levels below as zeros
  };
  const auto find = [&](std::size_t begin, std::size_t end, PlaceWord first) {
    return std::size_t(std::lower_bound(sorted.begin() + std::ptrdiff_t(begin),
                                        sorted.begin() + std::ptrdiff_t(end), first) -
                       sorted.begin());
  };
  const auto smaller = [](const Open& a, const Open& b) {
    const std::size_t of_a = a.end - a.begin, of_b = b.end - b.begin;
    return of_a != of_b ? of_a < of_b : a.begin > b.begin;
  };
  PlaceTree tree;
  tree.box = box;
  tree.words.resize(kPlaceRoots);
  std::vector<Open> open;
  const auto push = [&](const Open& node, std::uint32_t parent) {
    tree.nodes.push_back({node.begin, node.end, parent});
    open.push_back(node);
    std::push_heap(open.begin(), open.end(), smaller);
  };
  const auto pop = [&] {
    std::pop_heap(open.begin(), open.end(), smaller);
    const Open node = open.back();
    open.pop_back();
    return node;
  };
  const auto next_node = [&] { return std::uint32_t(tree.nodes.size()); };
  const auto add_place = [&](std::uint32_t node) {
    tree.places.push_back(node);
    return kPlaceLeaf | std::uint32_t(tree.places.size() - 1);
  };
  for (std::uint32_t root = 0; root < kPlaceRoots; ++root) {
    const std::uint64_t key = std::uint64_t(root) << kRootShift;
    const std::size_t begin = find(0, sorted.size(), key);
    const std::size_t end = root + 1 < kPlaceRoots
                                ? find(begin, sorted.size(), std::uint64_t(root + 1) << kRootShift)
                                : sorted.size();
    push({begin, end, next_node(), root, 0, key}, next_node());
  }
  while (!open.empty()) {
    const Open node = pop();
    // The node itself turns into a place for its children without words, beside up to eight others.
    const std::size_t places = tree.places.size() + open.size() + 9;
    if (node.end - node.begin < split || node.level == kPlaceLevels || places > most) {
      tree.words[node.word] = add_place(node.node);
      continue;
    }
    const auto children = std::uint32_t(tree.words.size());
    tree.words.resize(tree.words.size() + 8);
    tree.words[node.word] = children;
    const std::uint32_t shift = kPositionShift + 3 * (kPlaceLevels - 1 - node.level);
    std::uint32_t shared = 0;  // the node as a place
    for (std::uint32_t child = 0; child < 8; ++child) {
      const std::uint64_t key = node.key + (std::uint64_t(child) << shift);
      const std::size_t begin = find(node.begin, node.end, key);
      // The last child of the last root ends with the last word.
      const std::size_t end = child < 7 ? find(begin, node.end, key + (1ull << shift)) : node.end;
      if (begin == end) {
        if (shared == 0) shared = add_place(node.node);
        tree.words[children + child] = shared;
        continue;
      }
      push({begin, end, next_node(), children + child, node.level + 1, key}, node.node);
    }
  }
  return tree;
}

}  // namespace skywave
