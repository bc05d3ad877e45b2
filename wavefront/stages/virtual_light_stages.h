// The stage of virtual point lights: they shine on the surfaces that camera paths hit.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/worker.h"

namespace skywave {

// Adds what the current surfaces reflect of the virtual lights of the pass to their paths, light by
// light, so that a stream of shadow rays aims at one point. Lights whose path and the surfaces of
// `bounce` would be more than max_depth together do not count.
void AddVirtualLights(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock);

}  // namespace skywave
