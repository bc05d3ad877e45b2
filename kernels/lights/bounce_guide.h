// These kernels guide paths: directions of rays that scatter are drawn from a mixture of the BSDF
// and of a distribution that a pilot has learnt at the place of the surface
// (kernels/lights/places.h).
//
// A place has an axis, about which the hemisphere is cut into kBounceSide x kBounceSide cells of
// the same integral of the cosine: squares of the unit square, mapped to the unit disk (SampleDisc)
// and lifted. Inside a cell directions have the density of the cosine, so a place with equal cells
// draws like a diffuse surface that faces its axis.
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "kernels/lights/places.h"
#include "kernels/lights/search_tree.h"

namespace skywave {

inline constexpr int kLogBounceSide = 4;
inline constexpr std::uint32_t kBounceSide = 1u << kLogBounceSide;
inline constexpr std::uint32_t kBounceCells = kBounceSide * kBounceSide;

struct GuidePlace {
  float axis[3];  // world space, unit
  float share;    // of the directions that are guided, in [0, 1)
};
inline constexpr int kLogGuidePlaceWords = 2;

struct BounceGuideView {
  PlaceTreeView places;
  const GuidePlace* place;
  SearchTreeView lines;    // one tree a place, over the lines of cells
  SearchTreeView columns;  // one tree a line of each place, over its cells
  // The probability of cell c of place p, times their number: density[p * kBounceCells + c]. It is
  // the density of a direction over that of the cosine.
  const float* density;
};

// One row is one surface that a wave lights and scatters.
struct GuideColumns {
  float* place;           // FindPlaces
  float* share;           // of guided directions, 0 where the BSDF alone draws
  float* pdf;             // density of the current direction in the guide [1/sr]
  std::uint32_t* guided;  // rows of a range that the guide draws, one after the other

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.place), f(self.share), f(self.pdf), f(self.guided);
  }
};

// Writes the cell about a unit `axis` of each direction (dir) of rows [0, n), kBounceCells for
// those below the hemisphere.
void FindGuideCells(const float* axis, std::uint32_t n, const LightColumns& directions,
                    std::uint32_t* cell);

// Writes the directions in the middle of the cells about a unit `axis` to `dir` of rows
// [0, kBounceCells).
void FindCellCentres(const float* axis, const LightColumns& directions);

// Writes the share of rows [0, n) by their place.
void FindGuideShares(const BounceGuideView& guide, std::uint32_t n, const GuideColumns& rows);

// Lowers the share of rows [0, n) of Varying::kRoughness with metal and with sharp highlights,
// which are the BSDF's to draw: half as many samples for a highlight double its noise.
void LeaveGlossToBsdf(const SurfaceColumns& surfaces, std::uint32_t n, const GuideColumns& rows);

// Writes rows.pdf of rows [0, n) for directions `dir` of `directions`.
void FindGuideDensities(const BounceGuideView& guide, std::uint32_t n,
                        const LightColumns& directions, const GuideColumns& rows);

// Decides by the direction's uniform u of rows [0, n) whether the guide draws: writes those rows to
// `guided` and returns their number. The rest of u is uniform again.
std::uint32_t ChooseGuided(const GuideColumns& rows, std::uint32_t n,
                           const UniformColumns& direction, std::uint32_t* guided);

// Draws directions for rows guided[0, count) by their places: writes `dir` of these rows.
void DrawGuided(const BounceGuideView& guide, const GuideColumns& rows,
                const UniformColumns& direction, const std::uint32_t* guided, std::uint32_t count,
                const LightColumns& directions);

// Turns radiance of light samples into contributions, as BsdfKernels::evaluate_lights does, of
// surfaces whose directions are guided. `values` are those of BsdfKernels::evaluate.
void LightGuided(const SurfaceColumns& surfaces, const GuideColumns& rows,
                 const BsdfValueColumns& values, std::uint32_t n, const MisPolicy& mis,
                 const LightColumns& lights);

// Appends the rays of rows [0, n) that scatter into `dir` of `directions` and go on, as
// BsdfKernels::scatter does, but for roulette: paths go on four times as often. Returns the new
// number of rays.
std::uint32_t ScatterGuided(const SurfaceColumns& surfaces, const GuideColumns& rows,
                            const BsdfValueColumns& values, const LightColumns& directions,
                            const float* roulette, std::uint32_t n, const ScatterPolicy& policy,
                            const RayColumns& rays, std::uint32_t appended);

}  // namespace skywave
