// Random numbers are functions of (pixel, sample, dimension): Owen-scrambled Sobol' points by
// hashing (Burley 2020, "Practical Hash-based Owen Scrambling").
//
// Every pair of dimensions is a (0,2)-sequence of its own: the first two Sobol' dimensions, visited
// in an order shuffled by an Owen scramble of the index and scrambled by Owen scrambles of both
// coordinates, all three keyed by (pixel seed, pair). So 2^k consecutive aligned samples of a pixel
// are stratified in every elementary interval, and pairs are independent of each other.
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

// A path uses its pairs of dimensions in this order.
enum class SampleUse : std::uint32_t { kLight, kScatter, kLobe };
inline constexpr std::uint32_t kFilmPair = 0;
inline constexpr std::uint32_t kLensPair = 0xFFFFFFFFu;  // after those of all bounces
// The first dimension of this pair chooses between two mixed materials at a hit.
constexpr std::uint32_t MixturePair(std::uint32_t bounce) { return kLensPair - 1 - bounce; }
constexpr std::uint32_t SamplePair(std::uint32_t bounce, SampleUse use) {
  return 1 + 3 * bounce + static_cast<std::uint32_t>(use);
}

// A path uses fewer pairs than this; code that needs more for the same event adds multiples of it.
inline constexpr std::uint32_t kPairBlock = 1u << 16;

// A strategy that draws candidates of a light sample takes them from this many blocks after the
// sample's own.
inline constexpr std::uint32_t kCandidateBlocks = 3;

// Light paths have pairs of their own: this is added to those of SamplePair, MixturePair and their
// blocks, where bounce 0 is the light.
inline constexpr std::uint32_t kLightPathPairs = 0xC000u * kPairBlock;

// A path takes point sample * stride + offset of its pixel's sequence. If a hit takes n light
// samples, they are points sample * n + j of one sequence, so they are stratified among themselves
// too.
struct SampleIndexing {
  std::uint32_t stride = 1;
  std::uint32_t offset = 0;
};

// Writes rows [0, n) of `out`: the uniforms of pair `pair` of the path in row `rows[i]` of `paths`,
// or in row i if `rows` is null. `rows` and `out` are padded columns.
void DrawUniforms(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                  std::uint32_t pair, SampleIndexing indexing, const UniformColumns& out);

// Returns the seed of a pixel: a hash of its position in the film and of the seed of the frame.
std::uint32_t PixelSeed(std::uint32_t x, std::uint32_t y, std::uint32_t frame_seed);

}  // namespace skywave
