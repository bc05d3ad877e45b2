// Points to search for: photons without a scene.
#pragma once

#include <tbb/parallel_for.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "wavefront/records/point_tree.h"

namespace skywave {

struct Points {
  std::vector<float> axes[3];
};

// Returns points on the six sides of a cube of side 1; with `caustic`, every other point lies in a
// disk of 1/5000 of that area.
inline Points MakePoints(std::size_t count, bool caustic, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const float a = uniform(random), b = uniform(random);
    float p[3];
    if (caustic && i % 2 == 1) {
      const float radius = 0.02f * std::sqrt(a), angle = 6.2831853f * b;
      p[0] = 0.5f + radius * std::cos(angle), p[1] = 0, p[2] = 0.5f + radius * std::sin(angle);
    } else {
      const std::size_t side = random() % 6;
      p[side / 2] = float(side % 2), p[(side / 2 + 1) % 3] = a, p[(side / 2 + 2) % 3] = b;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) points.axes[axis].push_back(p[axis]);
  }
  return points;
}

// Builds the tree of points, with the index of each as its number.
inline PointTree TreeOf(const Points& points) {
  const std::size_t count = points.axes[0].size();
  const auto of = std::make_unique_for_overwrite<TreePoint[]>(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    of[i] = {.at = {points.axes[0][i], points.axes[1][i], points.axes[2][i]},
             .number = std::uint32_t(i)};
  });
  return PointTree({of.get(), count});
}

}  // namespace skywave
