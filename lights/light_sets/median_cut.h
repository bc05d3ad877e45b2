// Median cut (Debevec 2005, "A Median Cut Algorithm for Light Probe Sampling"; T 6.2) makes
// rectangles of equal energy.
#pragma once

#include <vector>

#include "lights/maps/sphere_map.h"
#include "lights/tables/summed_area_table.h"

namespace skywave {

struct MedianCutParameters {
  // The longest side is found by angle on the sphere, with widths scaled by the cosine of the
  // latitude of the region's middle (Debevec); false: by angle in (u, v), as in the thesis.
  bool scale_width = true;
};

// Cuts the map into `count` rectangles, round by round: every region into two halves of nearest to
// equal energy across its longest side; if count is not a power of two, the last round cuts only
// the regions of most energy. A region in which no cut across the longest side leaves energy on
// both sides is cut across the other, or, if that fails too, stays whole and another is cut in its
// place: there are fewer than `count` regions only if fewer texels have energy. A black map has
// none. Throws InputError for count < 1.
std::vector<Region> MedianCut(const SphereMap& map, int count,
                              const MedianCutParameters& parameters = {});

}  // namespace skywave
