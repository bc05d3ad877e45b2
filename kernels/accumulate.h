// Where light arrives: what escaped rays and unoccluded shadow rays add to their paths.
#pragma once

#include <atomic>
#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"

namespace skywave {

// Adds throughput * radiance of rows [0, n) to their paths, weighted against the light strategy
// that could have sampled the same direction (light_pdf). Rows with pdf == 0 have no such partner.
void AddEscapedRadiance(const EscapeColumns& rows, std::uint32_t n, const MisPolicy& mis,
                        const PathColumns& paths);

// Adds r, g, b of the rows [0, n) whose shadow ray arrived (t_far >= 0) to path[row].
void AddUnoccludedRadiance(const LightColumns& lights, const std::uint32_t* path, std::uint32_t n,
                           const PathColumns& paths);

// What a film keeps of a path's radiance (wavefront/film/film.h).
struct FilmScale {
  double units;  // a unit of radiance
  float limit;   // brightest sample [scene radiance]; limit * units <= 2^52
};
struct FilmCounts {
  std::uint64_t clamped, invalid;
};

// Adds rows [0, n) of `paths` to their pixels: three saturating sums a pixel at sums[3 * pixel].
// Returns how many samples were brighter than the limit, and how many had a NaN or negative
// channel. `shared`: other threads may add to the same pixels meanwhile.
FilmCounts AddToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                     std::uint64_t* sums, bool shared = false);

// The same for splats: `factor` times r, g, b of those rows [0, n) whose ray arrived (t_far >= 0)
// are added to pixel[row], which other threads may do meanwhile.
FilmCounts AddSplatsToFilm(const LightColumns& splats, const std::uint32_t* pixel, std::uint32_t n,
                           float factor, const FilmScale& scale, std::uint64_t* sums);

// The square of a sample of 2^52 units has 104 bits.
using Uint128 = unsigned __int128;

// The same for squares of the units that AddToFilm adds: three sums a pixel, exact.
void AddSquaresToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                      Uint128* sums);

// Integer addition that stays at the largest number: free of order, as nothing is subtracted.
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
