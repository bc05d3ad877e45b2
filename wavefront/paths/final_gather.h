// Follows the rays of a final gather.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/worker.h"

namespace skywave {

// Gathers (final gather, Jensen 1996): traces rays from every current surface that has a density,
// over mirrors and glass to the next that has one, and adds what those reflect of photons. A lookup
// blurs light by its disk, which is seen at a large angle from close by. So surfaces that a ray
// finds nearer than that (PhotonMap::near) are lit as the first one is, by light samples and
// caustics, and gather by a ray themselves (Jensen 2001). Rays of a surface are stratified. The
// current surfaces are those of `bounce`.
void GatherPhotons(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock);

}  // namespace skywave
