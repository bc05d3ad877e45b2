// FLIP, a measure of the difference that a viewer sees when two pictures alternate on a screen:
// Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", and for pictures of
// high dynamic range Andersson et al. 2021, "Visualizing Errors in Rendered High Dynamic Range
// Images".
#pragma once

#include <vector>

#include "image/image.h"

namespace skywave {

// The papers assume a screen of 3840 pixels and 0.7 m width at a distance of 0.7 m.
inline constexpr double kFlipPixelsPerDegree = 67;

struct Flip {
  std::vector<float> map;  // per pixel in [0, 1], rows from the top; 0: no difference is seen
  double mean = 0;
  // Of HDR-FLIP: the stops of the first and of the last exposure, and how many there are.
  double first_stops = 0, last_stops = 0;
  int exposures = 0;
};

// Returns FLIP of two pictures of the same size on a screen, whose values are linear light in
// [0, 1]; values outside of the range are clamped, and NaN counts as 0. The measure is symmetric in
// both pictures. Throws InputError for different sizes.
Flip LdrFlip(const Image& image, const Image& reference,
             double pixels_per_degree = kFlipPixelsPerDegree);

// Returns HDR-FLIP: each pixel's largest FLIP over a range of exposures that comes from the median
// and the greatest luminance of the reference, with the tone curve of Narkowicz. Values that
// are no radiance count as RepairRadiance has them.
Flip HdrFlip(const Image& image, const Image& reference,
             double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace skywave
