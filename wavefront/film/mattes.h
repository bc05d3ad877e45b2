// Mattes tell which objects or materials a pixel shows, and how much of each, as Cryptomatte 1.2
// writes them (Friedman and Jones 2015): a hash of each name, and its coverage.
//
// Coverage is exact and does not depend on the order of samples: a pixel keeps the weights of the
// kMatteSlots smallest ids that it has seen. An id that is among those has been there since its
// first sample, whatever came before, after, or from another film.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.h"
#include "wavefront/film/film_memory.h"

namespace skywave {

struct Scene;

// Ids that a pixel keeps, and those that a picture shows: two in each of its layers of R, G, B, A.
inline constexpr std::size_t kMatteSlots = 16, kMatteLayers = 3, kMatteRanks = 2 * kMatteLayers;

// What a matte tells apart.
enum class MatteOf : std::uint8_t { kObjects, kMaterials };
inline constexpr std::size_t kMattes = 2;

// The names of meshes, followed by those of instances where some have any, or of materials, by
// their numbers, and their ids. Instances without a name have the id 0.
struct MatteNames {
  std::vector<std::string> names;
  std::vector<std::uint32_t> ids;
  friend bool operator==(const MatteNames&, const MatteNames&) = default;
};
using Mattes = std::array<MatteNames, kMattes>;  // by MatteOf

// Returns the id of a name: MurmurHash3 (Appleby 2011; 32 bits, seed 0), changed where it would not
// be a normal number as the bits of a float. It is never 0.
std::uint32_t MatteId(std::string_view name);

MatteNames MakeMatteNames(std::vector<std::string> names);
// Returns the names of a scene. What a node stands in the world has the name of that. Meshes and
// materials without one are "mesh N" and "material N", N from 1 on.
Mattes MakeMattes(const Scene& scene);

// Returns how many ids the pixels of a film of these names keep.
std::size_t SlotsOf(const MatteNames& names);

// The columns of a matte: value `slot * pixels + pixel`. Ids ascend; 0: none.
struct MatteSums {
  std::size_t slots = 0;
  FilmValues<std::uint32_t> ids;
  FilmValues<std::uint64_t> weights;  // of samples, in two's complement
};

// Adds the weight of samples of a pixel that have seen `id`.
void AddToMatte(std::size_t pixel, std::uint32_t id, std::uint64_t weight, MatteSums& sums);

// An id and the weight of its samples.
struct MatteShare {
  std::uint32_t id = 0;
  double weight = 0;
};
// Returns what a pixel shows, the largest weights first.
std::array<MatteShare, kMatteRanks> RanksOf(const MatteSums& sums, std::size_t pixel);

// Returns the attributes of the layer called `layer`, among them the names of all ids.
Metadata MatteAttributes(std::string_view layer, const MatteNames& names);
// Returns whether an attribute of a header is one of those.
bool IsOfMatte(std::string_view attribute);

}  // namespace skywave
