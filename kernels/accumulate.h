// These kernels add the light of escaped rays and of unoccluded shadow rays to their paths, and
// paths to the film.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "kernels/lights/irradiance.h"

namespace skywave {

// Adds throughput * radiance of rows [0, n) to their paths, weighted against the light strategy
// that could have sampled the same direction (light_pdf). Rows with pdf == 0 count in full, because
// no light sample competes with them.
void AddEscapedRadiance(const EscapeColumns& rows, std::uint32_t n, const MisPolicy& mis,
                        const PathColumns& paths);

// Adds r, g, b of the rows [0, n) whose shadow ray arrived (t_far >= 0) to path[row].
void AddUnoccludedRadiance(const LightColumns& lights, const std::uint32_t* path, std::uint32_t n,
                           const PathColumns& paths);

// Subtracts rows [0, n) from path[row].
void SubtractControl(const ControlColumns& control, const std::uint32_t* path, std::uint32_t n,
                     const PathColumns& paths);

// A film stores radiance in these units and up to this limit (wavefront/film/film.h).
struct FilmScale {
  double units;  // units per radiance of 1
  float limit;   // brightest sample [scene radiance]; limit * units <= 2^52, or 2^42 if has_signs
  // Samples may be negative: sums are those of signed numbers in two's complement, modulo 2^64.
  bool has_signs = false;
};
struct FilmCounts {
  std::uint64_t clamped, invalid;
};

// Adds rows [0, n) of `paths` to their pixels: three saturating sums per pixel at sums[3 * pixel].
// Returns how many samples were brighter than the limit, and how many had a NaN or, without signs,
// negative channel. If `shared`, other threads may add to the same pixels meanwhile; such sums have
// no signs.
FilmCounts AddToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                     std::uint64_t* sums, bool shared = false);

// The same for splats: adds `factor` times r, g, b of those rows [0, n) whose ray arrived (t_far >=
// 0) to pixel[row], which other threads may do meanwhile.
FilmCounts AddSplatsToFilm(const LightColumns& splats, const std::uint32_t* pixel, std::uint32_t n,
                           float factor, const FilmScale& scale, std::uint64_t* sums);

// The square of a sample of 2^52 units has 104 bits.
using Uint128 = unsigned __int128;

// The samples of a pixel have two halves, which a denoiser compares: blocks of four samples, which
// are stratified among themselves, are dealt in the order of Thue and Morse. The first eight are
// dealt by pairs, so that any 4 * 2^k first samples have equal halves.
inline bool IsInSecondHalf(std::uint32_t sample) {
  const std::uint32_t block = sample < 8 ? sample >> 1 : sample >> 2;
  return (std::popcount(block) & 1) != 0;
}

// Sums from which noise is estimated, three per pixel but for numbers; null if not kept.
struct MomentSums {
  Uint128* squares;             // of the units of all samples, exact
  std::uint32_t* half_samples;  // the number of samples in second halves
  std::uint64_t* half;          // their units
  Uint128* half_squares;        // kept if `half` is
};
// Adds rows [0, n) of `paths`, in the units that AddToFilm adds, to those that are kept.
void AddMomentsToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                      const MomentSums& sums);

// Adds integers and stays at the largest number; the order does not matter, as nothing is
// subtracted.
template <class Unsigned>
constexpr Unsigned SaturatingSum(Unsigned a, Unsigned b) {
  const Unsigned sum = a + b;
  return sum < a ? ~Unsigned{0} : sum;
}
// The same where other threads add too.
inline void AddSaturating(std::uint64_t& sum, std::uint64_t value) {
  const std::atomic_ref<std::uint64_t> shared(sum);
  std::uint64_t seen = shared.load(std::memory_order_relaxed);
  while (
      !shared.compare_exchange_weak(seen, SaturatingSum(seen, value), std::memory_order_relaxed)) {
  }
}

}  // namespace skywave
