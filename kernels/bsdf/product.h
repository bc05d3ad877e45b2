// Product sampling draws a cell of the map for each surface, in proportion to the cell's light
// times the surface's BSDF (Conty Estevez and Lecocq 2018, "Fast Product Importance Sampling of
// Environment Maps"), then a texel in the cell.
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/lights/texel_samplers.h"

namespace skywave {

// Surfaces are weighed in chunks: the sums of a chunk over a hundred cells stay in the first-level
// cache.
inline constexpr std::uint32_t kProductRows = 64;
inline constexpr std::uint32_t kMaxProductCells = 256;
// The stride between the sums of one cell and the next has room for whole vectors and is no power
// of two, because those columns would all fall on the same cache lines.
inline constexpr std::uint32_t kProductStride = PaddedRows(kProductRows);

// The places where a chunk of surfaces draws its samples.
struct CellPicks {
  alignas(64) std::uint32_t cell[kProductStride];
  alignas(64) float x[kProductStride];            // rest of the uniform after the pick, in [0, 1)
  alignas(64) float probability[kProductStride];  // that of the cell; 0: no cell has weight
};

// Picks a cell for each of rows [0, n), n <= kProductRows, at uniforms u, by the sums that
// BsdfKernels::weigh_cells writes, kProductStride apart. Writes the last sum of every row to
// `norm`.
void PickCells(const float* sums, std::uint32_t count, const float* u, std::uint32_t n,
               CellPicks& picks, float* norm);

// Draws a texel in the picked cell of each of rows [0, n), at (picks.x, v). `cells.density` is that
// of each texel inside its cell [1/sr].
void SamplePickedCells(const EnvironmentView& map, const CellsView& cells, const CellPicks& picks,
                       const float* v, std::uint32_t n, float samples, const LightColumns& out);

// Sets cell[i] to cell_of_texel of the texel that row i of `rows` looks at, for rows [0, n).
void FindCells(const EnvironmentView& map, const std::uint32_t* cell_of_texel, std::uint32_t n,
               const EscapeColumns& rows, std::uint32_t* cell);

// Copies the columns by which a BSDF weighs cells, and light_norm, from row from[i] of `surfaces`
// to row i of `out`, for rows [0, n), n <= kProductRows.
void GatherWeighedSurfaces(const SurfaceColumns& surfaces, const MaterialView& materials,
                           const BsdfTraits& bsdf, const std::uint32_t* from, std::uint32_t n,
                           const SurfaceColumns& out);

// Multiplies light_pdf[i] by weight[i] / norm[i] (0 where norm is) for rows [0, n).
void ScaleByPick(const float* weight, const float* norm, std::uint32_t n, float* light_pdf);

}  // namespace skywave
