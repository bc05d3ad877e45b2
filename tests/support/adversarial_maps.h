// Illumination maps that challenge samplers, their orientations in the world, and the positions of
// map points on the sphere, in double.
#pragma once

#include <array>
#include <span>
#include <string>

#include "lights/maps/environment_map.h"
#include "tests/support/random_rows.h"

namespace skywave {

struct NamedMap {
  std::string name;
  Image latlong;
};
std::span<const NamedMap> AdversarialMaps();
// Returns the map of that name.
const Image& AdversarialMap(const std::string& name);

struct NamedOrientation {
  std::string name;
  std::array<float, 9> map_from_world;
};
// Returns three orientations: unrotated, rotated about an oblique axis, and mirrored.
std::span<const NamedOrientation> Orientations();

// Returns the rounded map as strategies hold it: the values for rays through the centres of the
// texels.
Image HeldMap(const EnvironmentMap& map);

// Convert between directions in the world and positions on a map, u and v in [0, 1].
Vec WorldDirection(const std::array<float, 9>& map_from_world, double u, double v);
void MapPosition(const std::array<float, 9>& map_from_world, Vec world, double& u, double& v);

// Returns the distance of a position to the nearest border between texels, measured on the sphere
// [rad].
double BorderDistance(int width, int height, double u, double v);

}  // namespace skywave
