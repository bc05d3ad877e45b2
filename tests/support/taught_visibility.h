// Teaches the strategy `visibility` for tests that have no pilot.
#pragma once

#include <memory>
#include <vector>

#include "lights/strategies/visibility.h"
#include "tests/support/random_rows.h"

namespace skywave {

inline constexpr PlaceBox kTaughtBox = {{-1.1f, -1.1f, -1.1f}, 2.2f};

inline VisibilityRay RayOf(const VisibilityStrategy& strategy, Vec point, Vec normal, Vec to,
                           bool open) {
  const float dir[3] = {float(to.x), float(to.y), float(to.z)};
  alignas(kColumnAlignment) float columns[3][kPadRows] = {{dir[0]}, {dir[1]}, {dir[2]}};
  alignas(kColumnAlignment) std::uint32_t cell[kPadRows];
  strategy.CellsOf(columns[0], columns[1], columns[2], 1, cell);
  return PackVisibilityRay(kTaughtBox, {float(point.x), float(point.y), float(point.z)},
                           {float(normal.x), float(normal.y), float(normal.z)}, cell[0], open);
}

// Returns rays from random points of the unit sphere, of which those get out for which
// `open(point, direction)` is true.
template <class Open>
std::vector<VisibilityRay> RaysFromSphere(const VisibilityStrategy& strategy, std::uint32_t count,
                                          const Open& open) {
  Random random(77);
  std::vector<VisibilityRay> rays;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec point = random.Direction(), to = random.Direction();
    if (Dot(point, to) > 0) rays.push_back(RayOf(strategy, point, point, to, open(point, to)));
  }
  return rays;
}

// Returns the strategy as it is in front of a wall with an opening, of which a part of the sphere
// sees nothing.
inline std::unique_ptr<EnvStrategy> Teach(const VisibilityStrategy& strategy) {
  std::vector<VisibilityRay> rays = RaysFromSphere(strategy, 20000, [](Vec point, Vec to) {
    return point.z < 0.5 && to.y > 0.3 && to.x > -0.2;
  });
  return strategy.Taught(rays, kTaughtBox);
}

}  // namespace skywave
