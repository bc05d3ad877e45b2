// The stages of the irradiance cache: diffuse surfaces look it up, and paths end there.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/worker.h"

namespace skywave {

// Adds what the current diffuse surfaces reflect of cached irradiance to their paths. w.irradiance
// keeps which of them have found records: none in pilots, which have no cache.
void AddCachedIrradiance(const FrameView& frame, Worker& w, StageClock& clock);

// Moves those of rays [0, n) whose surfaces have found records to w.irradiance->ended, and their
// number to `ended`: their paths end with the light that they meet. Returns the number of the
// others, which stay.
std::uint32_t EndCachedPaths(const RayColumns& rays, std::uint32_t n, Worker& w,
                             std::uint32_t& ended);

}  // namespace skywave
