// The halves of a picture, cleaned by the statistics of its samples (kernels/cross_filter.h).
#pragma once

#include <vector>

#include "job/denoise/planes.h"

namespace skywave {

// Replaces the noise of both halves by what SmoothNoise makes of it.
void SmoothNoises(const DenoiserInput& input, DenoiserPlanes& planes);

// Returns the clean halves of a picture, with rims.
HalfTables FilterHalves(const DenoiserPlanes& planes);

// Returns what all levels of the filter but the last make of the halves of a picture, with rims: by
// these and the halves themselves a level decides what is averaged.
std::vector<HalfTables> FilterGuides(const DenoiserPlanes& planes);
// Filters a part of the picture's light, with its rim, as its guides say: by the mean of the
// weights of both halves. That is linear in the light.
void FilterByGuides(const DenoiserPlanes& planes, const std::vector<HalfTables>& guides,
                    const soa::Table<HalfPlanes>& part);

}  // namespace skywave
