// What camera paths of a pilot find for the guide of light paths
// (wavefront/guiding/emission_guide.h).
#pragma once

#include <cstdint>

namespace skywave {

// Light that came in along a line: what a camera path gained by it.
struct GuideSample {
  std::uint32_t cell;    // of the direction
  float u, v;            // of the place (DiskPlaceColumns)
  float point[3];        // where it came in, world space
  std::uint32_t pixel;   // of the pilot's film
  std::uint64_t weight;  // [1/kGuideSampleUnits of the mean radiance of the sky]
};
inline constexpr double kGuideSampleUnits = 1 << 20;

}  // namespace skywave
