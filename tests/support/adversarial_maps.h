// Illumination maps that break samplers, the ways they can lie in the world, and where the points
// of a map are on the sphere, in double.
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
// The map of that name.
const Image& AdversarialMap(const std::string& name);

struct NamedOrientation {
  std::string name;
  std::array<float, 9> map_from_world;
};
// As it is, rotated about an odd axis, and mirrored.
std::span<const NamedOrientation> Orientations();

// The map as strategies hold it, rounded: what a ray through the centre of every texel finds.
Image HeldMap(const EnvironmentMap& map);

// Between directions in the world and positions on a map, u and v in [0, 1].
Vec WorldDirection(const std::array<float, 9>& map_from_world, double u, double v);
void MapPosition(const std::array<float, 9>& map_from_world, Vec world, double& u, double& v);

// Distance of a position to the nearest border between texels, measured on the sphere [rad].
double BorderDistance(int width, int height, double u, double v);

}  // namespace skywave
