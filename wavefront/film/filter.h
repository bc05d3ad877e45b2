// Pixel filters as tables: where in its pixel a sample lies, and what it counts there.
#pragma once

#include <vector>

#include "scene/scene.h"

namespace skywave {

// Returns the radius of a filter for which the user gave none [pixels].
float DefaultFilterRadius(PixelFilter filter);

// Returns whether some weights of the filter are negative.
constexpr bool HasSigns(PixelFilter filter) {
  return filter == PixelFilter::kMitchell || filter == PixelFilter::kSinc;
}

// Returns kFilterCells + 1 offsets [pixels]: the inverse of the cumulative distribution of the
// filter's magnitude.
std::vector<float> FilterOffsets(PixelFilter filter, float radius);

// Returns kFilterCells factors of the samples in the cells of FilterOffsets that make their
// expectation that of the filter, or nothing for filters without signs, where all are 1.
std::vector<float> FilterFactors(PixelFilter filter, float radius,
                                 const std::vector<float>& offsets);

// Returns kFilterCells densities of the same filter, as FilterView needs them, from FilterOffsets.
std::vector<float> FilterDensities(const std::vector<float>& offsets, float radius);

}  // namespace skywave
