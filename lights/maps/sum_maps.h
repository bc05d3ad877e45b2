// Several infinitely distant lights as one.
#pragma once

#include <array>
#include <vector>

#include "image/image.h"

namespace skywave {

// A lat-long map and how it lies in the world.
struct OrientedMap {
  Image latlong;
  // Columns of the rotation, or mirroring, from map space (right, forward, up) to the world.
  std::array<std::array<float, 3>, 3> world_from_map;
};

// The sum of `maps` on the grid and in the frame of the finest one, the first of several. The
// others are interpolated between the centres of their texels, each texel of the sum the mean of
// 2 x 2 points, and then scaled channel by channel so that their mean over the sphere is kept.
// There is at least one map. Runs on the threads of the caller's arena.
OrientedMap SumMaps(std::vector<OrientedMap> maps);

}  // namespace skywave
