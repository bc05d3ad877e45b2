// Camera paths of a pilot find samples for the guide of light paths
// (wavefront/records/emission_guide.h).
#pragma once

#include <cstdint>

namespace skywave {

// A guide sample is light that came in along a line, and the gain of a camera path by it.
struct GuideSample {
  std::uint32_t cell;    // cell of the direction
  float u, v;            // place on the disk (DiskPlaceColumns)
  float point[3];        // on the surface that it reached, world space
  std::uint32_t pixel;   // pixel of the pilot's film
  std::uint64_t weight;  // [1/kGuideSampleUnits of the environment's mean radiance]
};
inline constexpr double kGuideSampleUnits = 1 << 20;

}  // namespace skywave
