// The densities by which importance sampling draws the texels of a map: a column, and a row in it
// (T 6.3, figures 6.3 to 6.7).
#pragma once

#include <vector>

#include "lights/maps/sphere_map.h"

namespace skywave {

// A function of u or v that is constant inside texels: density over [0, 1), and its integral up to
// the end of each texel.
struct TexelDensity1D {
  std::vector<double> density, cumulative;
};

// Of columns: p(u). Zero if the map is black.
TexelDensity1D ColumnDensity(const SphereMap& map);
// Of the rows of a column: p(v | u). Zero if that is black.
TexelDensity1D RowDensity(const SphereMap& map, int column);

// Returns the map with each row times its solid angle, the largest 1: p(u, v) to scale.
Image JointDensity(const SphereMap& map);

// Returns the column of the texel with most energy, the first of them.
int BrightestColumn(const SphereMap& map);

}  // namespace skywave
