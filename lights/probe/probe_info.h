// Describes a map before it lights anything.
#pragma once

#include <array>
#include <vector>

#include "lights/light_sets/strata.h"
#include "lights/maps/sphere_map.h"

namespace skywave {

struct BrightSpot {
  int x, y;           // brightest texel
  Vector3 direction;  // to its centre, map space
  double luminance;   // of that texel
  double share = 0;   // part of the map's energy within kSpotRadiusDegrees of it
};
inline constexpr double kSpotRadiusDegrees = 5;

struct ProbeInfo {
  int width, height;                       // size of the lat-long map
  double least, greatest, least_positive;  // luminance
  double energy;                           // [luminance * sr]
  std::array<double, 3> mean;              // radiance per channel over the sphere
  std::vector<BrightSpot> spots;           // descending; no two within kSpotRadiusDegrees
  // The row of the thesis's table 7.1: areas and energies in pixels, which are 2 W H / pi for the
  // whole sphere (SphereMap::AreaInPixels), and A and B by the greatest variation.
  double sphere_pixels, energy_pixels, zeta_minimum;
  Strata strata;
};

// Reports at most `spots` bright spots.
ProbeInfo DescribeMap(const SphereMap& map, int spots = 5);

}  // namespace skywave
