// Resampled importance sampling (Talbot, Cline and Egbert 2005) keeps one of several candidate
// directions, with a probability in proportion to what it would contribute unoccluded.
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"

namespace skywave {

// One row is the candidate that a surface has kept so far (weighted reservoir sampling, Chao 1982).
struct ReservoirColumns {
  float *dir_x, *dir_y, *dir_z;  // world space, unit
  float *r, *g, *b;              // radiance
  float* target;                 // luminance of value times radiance; 0: none kept
  float* sum;                    // weights of all candidates offered
  float* x;                      // rest of the uniform for further choices, in [0, 1)

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.dir_x), f(self.dir_y), f(self.dir_z);
    f(self.r), f(self.g), f(self.b), f(self.target), f(self.sum), f(self.x);
  }
};

// A surface is offered so many candidates from the map and from its BSDF.
struct CandidateCounts {
  std::uint32_t map = 4, bsdf = 2;
};

// Empties rows [0, n); u is the uniform that all choices of a row are made with.
void StartReservoirs(const float* u, std::uint32_t n, const ReservoirColumns& reservoirs);

// Offers row i of `lights` (dir, radiance, and as pdf that of a candidate from the map) with
// `values` (value and pdf of the BSDF there) to reservoir i, for rows [0, n). A candidate's weight
// is its target over the density of all candidates of the surface (the balance heuristic), so it
// does not depend on where the candidate came from.
void OfferCandidates(const LightColumns& lights, const BsdfValueColumns& values,
                     CandidateCounts counts, std::uint32_t n, const ReservoirColumns& reservoirs);

// Turns the kept candidates of rows [0, n) into light samples of infinite density (LightColumns),
// each one of `samples`: radiance times sum of weights over target.
void TakeFromReservoirs(const ReservoirColumns& reservoirs, std::uint32_t n, float samples,
                        const LightColumns& out);

}  // namespace skywave
