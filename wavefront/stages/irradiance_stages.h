// The stages of the irradiance cache: diffuse surfaces look it up, and paths end there.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/worker.h"

namespace skywave {

// Adds what the diffuse surfaces at hand reflect of cached irradiance to their paths. Which of them
// have found records is kept in w.irradiance.
void AddCachedIrradiance(const FrameView& frame, Worker& w, StageClock& clock);

// Of rays [0, n) that leave the surfaces at hand, moves those of surfaces that have found records,
// whose paths end with the light that they meet, to w.irradiance->ended; returns the number of the
// others. `ended` gets that of those.
std::uint32_t EndCachedPaths(const RayColumns& rays, std::uint32_t n, Worker& w,
                             std::uint32_t& ended);

}  // namespace skywave
