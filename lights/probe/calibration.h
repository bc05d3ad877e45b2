// The calibration map shows how a renderer orients maps.
#pragma once

#include <array>

#include "image/image.h"
#include "lights/vector3.h"

namespace skywave {

struct CalibrationAxis {
  const char* name;  // "+R": right, forward, up
  Vector3 direction;
  std::array<float, 3> radiance;  // radiance of the disk around it
};
// Right is red, left cyan, forward green, back magenta, up blue, down yellow.
extern const CalibrationAxis kCalibrationAxes[6];
inline constexpr double kCalibrationDiskDegrees = 18;

// Returns a lat-long map of width = 2 * height: grey (upper half brighter) with lines every 15
// degrees and a disk of kCalibrationDiskDegrees around each axis with its name on it, upright for a
// viewer on the ground; the name of up has its top at the back, that of down at the front. The axes
// themselves show the plain disk.
Image CalibrationMap(int height);

}  // namespace skywave
