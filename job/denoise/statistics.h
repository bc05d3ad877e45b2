// The halves of a picture, cleaned by the statistics of its samples (kernels/cross_filter.h).
#pragma once

#include "job/denoise/planes.h"

namespace skywave {

// Replaces the noise of both halves by what SmoothNoise makes of it.
void SmoothNoises(const DenoiserInput& input, DenoiserPlanes& planes);

// Returns the clean halves of a picture, with rims.
HalfTables FilterHalves(const DenoiserPlanes& planes);

}  // namespace skywave
