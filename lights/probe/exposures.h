// Photographs of one view at several exposures become a picture of its radiance (T 5.1; Debevec and
// Malik 1997, "Recovering High Dynamic Range Radiance Maps from Photographs").
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"

namespace skywave {

struct Exposure {
  std::string name;  // for messages
  Image image;       // the numbers of the file
  // Codes of a camera with a response that is not known, over 255; false: numbers in proportion to
  // the light.
  bool coded = true;
  double exposure = 1;  // time, times sensitivity and area of the aperture where these differ
};

// ln of the exposure that gives a code, by channel; 0 at code 128.
using Response = std::array<std::array<double, 256>, 3>;

struct AssembledExposures {
  Image image;  // radiance: of codes 1 where an exposure of 1 gives 128, of numbers as they are
  std::optional<Response> response;       // of codes
  std::vector<std::array<int, 2>> shift;  // of each exposure against the middle one [pixels]
  // Values that no exposure shows as more than black, or less than white; the image has a bound.
  std::size_t black = 0, white = 0;
};

// Moves exposures over each other (Ward 2003) unless `align` is false; finds the response that
// makes them agree, by least squares (equation 3, with the radiance of every pixel eliminated); and
// takes the mean of the logarithm of radiance weighted by how far codes are from black and white
// (equation 6). What moves between exposures is not found: there is no deghosting. Throws
// InputError with the name of an exposure for fewer than two, sizes or kinds that differ, exposures
// that are equal or not above 0, and codes that do not grow with them.
AssembledExposures AssembleExposures(std::vector<Exposure> exposures, bool align);

}  // namespace skywave
