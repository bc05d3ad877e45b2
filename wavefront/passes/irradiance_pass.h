// The first pass of `irradiance-cache` makes the records that the frame looks up.
#pragma once

#include "wavefront/frame.h"
#include "wavefront/records/irradiance_cache.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Camera paths of a pilot, which is the whole film, find the diffuse surfaces that are seen. Round
// after round, from coarse grids of its pixels to fine ones, those at which no record counts get
// one. So records depend on neither threads nor wave, nor on which part of the film or which
// samples are rendered.
IrradianceCache MakeIrradianceCache(const FrameView& frame, WorkerPool& pool);

}  // namespace skywave
