// These kernels draw directions by visibility that was learnt place by place: a place
// (kernels/lights/places.h) has a distribution of its own over the cells of the map.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lights/environment.h"
#include "kernels/lights/places.h"
#include "kernels/lights/texel_samplers.h"

namespace skywave {

// The distributions of the learnt places over `cells` cells: one tree of `trees` a place, and what
// it draws: probability[place * cells + cell]. Places from `learnt` on have none: there light is
// drawn by another technique.
struct PlacePicksView {
  SearchTreeView trees;
  const float* probability;
  std::uint32_t cells, learnt;
};

// All that a sample needs of its texel lies together, because each access to a large table is a
// line that no cache holds. A slot of an alias table (CellsView) has the record of its number.
struct SlotTexel {
  std::uint32_t texel;  // row * width + column
  PackedRadiance radiance;
  float density;  // of the texel inside its cell [1/sr]
  std::uint32_t unused;
};
struct SlotTexelsView {
  const std::uint32_t* begin;  // first slot of a cell; cells + 1 entries
  const AliasSlot* slots;
  const SlotTexel* texels;
};

// Surfaces and rays are drawn and weighed in chunks of at most so many.
inline constexpr std::uint32_t kPlaceRows = 128;

// Picks a cell for each of surfaces [0, n), n <= kPlaceRows, by its place, which is in
// `light_norm`, and draws a texel of it. With `mixed`, rows of places that are not learnt stay as
// they are; without, there are none.
void SampleFromPlaces(const EnvironmentView& map, const SlotTexelsView& texels,
                      const PlacePicksView& picks, const float* light_norm,
                      const UniformColumns& uniforms, std::uint32_t n, float samples, bool mixed,
                      const LightColumns& out);

// Multiplies light_pdf of rows [0, n) by the probability of cell[i] at the place of surface
// from[i], which is in `light_norm`. Where the place is not learnt, light_pdf becomes other[i]; if
// `other` is null there are no such rows. Rows without a density, whose pdf is 0, get anything.
void ScaleByPlace(const PlacePicksView& picks, const float* light_norm, const std::uint32_t* cell,
                  const float* other, std::uint32_t n, const EscapeColumns& rows);

}  // namespace skywave
