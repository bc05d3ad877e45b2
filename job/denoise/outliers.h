// Outliers: single samples that are far too bright for the number of samples.
#pragma once

#include <cstdint>

#include "job/denoise/planes.h"

namespace skywave {

struct OutlierExcess {
  std::uint64_t outliers = 0;
  soa::Table<TexturePlanes> spread;  // radiance to be added to the picture; empty without outliers
};

// Takes the excess of outliers out of both halves of the planes, and returns it spread over the
// surfaces around.
OutlierExcess TakeOutliers(const DenoiserInput& input, DenoiserPlanes& planes);

}  // namespace skywave
