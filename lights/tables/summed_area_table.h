// Sums over rectangles of texels take constant time (Crow 1984). They are in double precision: a
// sun of 1e6 in a dim sky on an 8k map is beyond float.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "lights/maps/sphere_map.h"

namespace skywave {

// A region holds texels [x0, x1) x [y0, y1).
struct Region {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
inline bool operator==(const Region& a, const Region& b) {
  return a.x0 == b.x0 && a.y0 == b.y0 && a.x1 == b.x1 && a.y1 == b.y1;
}

// Rounding leaves a sum wrong by up to kSumNoise of the whole table's: nothing below that differs
// reliably from zero.
inline constexpr double kSumNoise = 1e-12;

template <int kChannels>
struct SummedAreaTable {
  using Sums = std::array<double, kChannels>;
  int width = 0, height = 0;
  std::vector<Sums> corner;  // (width + 1) * (height + 1): sums over [0, x) x [0, y)

  const Sums& Corner(int x, int y) const { return corner[std::size_t(y) * (width + 1) + x]; }
  Sums Sum(const Region& r) const {
    Sums sums;
    for (int c = 0; c < kChannels; ++c) {
      sums[c] = (Corner(r.x1, r.y1)[c] - Corner(r.x0, r.y1)[c]) -
                (Corner(r.x1, r.y0)[c] - Corner(r.x0, r.y0)[c]);
    }
    return sums;
  }
};

// Sums energy [luminance * sr].
SummedAreaTable<1> EnergyTable(const SphereMap& map);
// Sums energy and the integral of luminance * direction: right, forward, up.
SummedAreaTable<4> MomentTable(const SphereMap& map);
// Sums radiance times solid angle: red, green, blue.
SummedAreaTable<3> IrradianceTable(const SphereMap& map);

}  // namespace skywave
