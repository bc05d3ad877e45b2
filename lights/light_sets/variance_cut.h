// Greedy variance cut makes rectangles of little spread, after Viriyothai and Debevec 2009
// ("Variance Minimization Light Probe Sampling") with the variance taken on the sphere.
#pragma once

#include <vector>

#include "lights/maps/sphere_map.h"
#include "lights/tables/summed_area_table.h"

namespace skywave {

// Returns the mean square distance of a region's energy from its centroid times its energy: with E
// the energy and S the integral of luminance * direction, E - |S|^2 / E. It has no seam and no
// pole.
double SphericalVariance(const std::array<double, 4>& energy_and_moment);

// Cuts the map into `count` rectangles: always the region of largest variance, across either side,
// where the variances of the parts add up to least. Both parts have energy, so there are fewer than
// `count` regions only if fewer texels have energy. A black map has none. Throws InputError for
// count < 1.
std::vector<Region> VarianceCut(const SphereMap& map, int count);

}  // namespace skywave
