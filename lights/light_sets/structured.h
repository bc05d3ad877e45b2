// Structured importance sampling (Agarwal, Ramamoorthi, Belongie and Jensen 2003) cuts a map into
// strata of connected texels: first by thresholds of luminance, then by distance.
#pragma once

#include "lights/tables/cells.h"

namespace skywave {

struct StructuredParameters {
  int levels = 6;        // thresholds: 0, 1, 2, ... standard deviations of the luminance
  double power = 0.25;   // importance of a stratum: energy * min(solid angle, widest)^power
  double widest = 0.01;  // [sr]; what is wider needs no more samples for that
};

// Cells, and a direction in each.
struct PlacedCells {
  CellMap cell_of_texel;
  std::vector<Vector3> samples;  // unit, map space
};

// Shares `count` samples among the connected parts of the map above each threshold, from the
// brightest down, in proportion to their importance; a part too small for a sample joins the part
// around it. The samples of a part are farthest-point samples (Hochbaum and Shmoys 1985), away from
// those of the brighter parts too, and its cells the texels nearest to them, so that no cell
// crosses a threshold. There are fewer only if fewer texels have energy; a black map has none.
// Throws InputError for count < 1. Time grows with texels times samples.
PlacedCells StructuredCells(const SphereMap& map, int count,
                            const StructuredParameters& parameters = {});

}  // namespace skywave
