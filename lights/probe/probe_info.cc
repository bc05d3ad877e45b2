#include "lights/probe/probe_info.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lights/maps/environment_map.h"

namespace skywave {
namespace {

// Finds the brightest texel that is not `taken`; returns false if none has light.
bool FindSpot(const SphereMap& map, const std::vector<bool>& taken, BrightSpot& spot) {
  float greatest = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < map.texels(); ++i) {
    if (!taken[i] && map.luminance[i] > greatest) greatest = map.luminance[i], at = i;
  }
  if (!(greatest > 0)) return false;
  spot.x = int(at % map.width);
  spot.y = int(at / map.width);
  spot.direction = map.TexelCentre(spot.x, spot.y);
  spot.luminance = greatest;
  return true;
}

}  // namespace

ProbeInfo DescribeMap(const SphereMap& map, int spots) {
  ProbeInfo info = {.width = map.width, .height = map.height};
  info.least = info.greatest = map.luminance[0];
  info.least_positive = std::numeric_limits<double>::infinity();
  for (float luminance : map.luminance) {
    info.least = std::min<double>(info.least, luminance);
    info.greatest = std::max<double>(info.greatest, luminance);
    if (luminance > 0) info.least_positive = std::min<double>(info.least_positive, luminance);
  }
  info.energy = map.energy;
  info.mean = SphereMean(*map.image);
  info.sphere_pixels = map.AreaInPixels(4 * std::numbers::pi);
  info.energy_pixels = map.AreaInPixels(map.energy);
  info.strata = StrataByVariation(map, &info.zeta_minimum);

  std::vector<bool> taken(map.texels());
  const double cosine = std::cos(kSpotRadiusDegrees * std::numbers::pi / 180);
  BrightSpot spot = {};
  while (int(info.spots.size()) < spots && FindSpot(map, taken, spot)) {
    double energy = 0;
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        const bool centre = x == spot.x && y == spot.y;
        if (!centre && Dot(map.TexelCentre(x, y), spot.direction) < cosine) continue;
        taken[std::size_t(y) * map.width + x] = true;
        energy += map.Energy(x, y);
      }
    }
    spot.share = energy / map.energy;
    info.spots.push_back(spot);
  }
  return info;
}

}  // namespace skywave
