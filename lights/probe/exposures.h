// Photographs of one view at several exposures become a picture of its radiance (T 5.1).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "image/image.h"
#include "lights/probe/camera_response.h"

namespace skywave {

struct AssembledExposures {
  Image image;  // radiance: of codes 1 where an exposure of 1 gives 128, of numbers as they are
  std::optional<Response> response;       // of codes
  std::vector<std::array<int, 2>> shift;  // of each exposure against the middle one [pixels]
  // Values that no exposure shows as more than black, or less than white; the image has a bound.
  std::size_t black = 0, white = 0;
};

// Moves exposures over each other (Ward 2003) unless `align` is false, finds the response of codes,
// and takes the mean of radiance as `method` does: of its logarithm, weighted by how far codes are
// from black and white (Debevec and Malik 1997, equation 6), or of radiance itself, weighted by
// that and the square of the exposure (Robertson et al. 2003). What moves between exposures is not
// found: there is no deghosting. Throws InputError with the name of an exposure for fewer than two,
// sizes or kinds that differ, exposures that are equal or not above 0, and codes that do not grow
// with them.
AssembledExposures AssembleExposures(std::vector<Exposure> exposures, bool align,
                                     ResponseMethod method = ResponseMethod::kDebevec);

}  // namespace skywave
