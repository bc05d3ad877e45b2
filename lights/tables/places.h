// Builds the octrees of places (kernels/lights/places.h) from what a pilot has found there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/lights/places.h"

namespace skywave {

// A cube in which places lie.
struct PlaceBox {
  std::array<float, 3> low = {};
  float side = 0;
};

// A word encodes where a surface is and which way it faces. The bits, from the highest: the root of
// its place, 12 x 3 bits of position in the order of the octrees, kPlaceWordFree bits for others
// (from kPlaceWordShift on), 2 x 8 of the normal across its axis. So sorted words are sorted by
// place.
using PlaceWord = std::uint64_t;
inline constexpr std::uint32_t kPlaceWordShift = 16, kPlaceWordFree = 9;
PlaceWord PackPlace(const PlaceBox& box, const std::array<float, 3>& org,
                    const std::array<float, 3>& normal);

// Returns the mean normal of words that belong to one root, 0 for none.
std::array<double, 3> MeanNormal(std::span<const PlaceWord> words);

// Octrees, of which a node has words [begin, end).
struct PlaceTree {
  struct Node {
    std::size_t begin, end;
    std::uint32_t parent;  // a smaller index than its own, or that itself for a root
  };
  PlaceBox box;
  std::vector<std::uint32_t> words;   // as PlaceTreeView has them
  std::vector<Node> nodes;            // all that have words
  std::vector<std::uint32_t> places;  // the node of each place

  // Returns the size of the octrees themselves, which is what lookups need.
  std::size_t bytes() const { return words.size() * sizeof(std::uint32_t); }
  PlaceTreeView view() const {
    return {.nodes = words.data(),
            .low = {box.low[0], box.low[1], box.low[2]},
            .steps = float(1 << kPlaceLevels) / box.side};
  }
  // Gives each place another number: place[i] to place i.
  void Renumber(std::span<const std::uint32_t> place);
};

// Splits nodes that have `split` of the sorted words or more, those with most words first, while
// there are no more than `most` places. A node that is split is also a place itself for its
// children without words.
PlaceTree BuildPlaceTree(std::span<const PlaceWord> sorted, const PlaceBox& box, std::size_t split,
                         std::size_t most);

}  // namespace skywave
