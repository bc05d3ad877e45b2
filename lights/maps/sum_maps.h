// Several infinitely distant lights become one.
#pragma once

#include <array>
#include <vector>

#include "image/image.h"

namespace skywave {

// An oriented map is a lat-long map and its orientation in the world.
struct OrientedMap {
  Image latlong;
  // Columns of the rotation, or mirroring, from map space (right, forward, up) to the world.
  std::array<std::array<float, 3>, 3> world_from_map;
};

// Returns the sum of `maps` on the grid and in the frame of the finest one, the first of several.
// The others are interpolated between the centres of their texels, with each texel of the sum the
// mean of 2 x 2 points, and then scaled channel by channel so that their mean over the sphere is
// kept. There is at least one map. Runs on the threads of the caller's arena.
OrientedMap SumMaps(std::vector<OrientedMap> maps);

}  // namespace skywave
