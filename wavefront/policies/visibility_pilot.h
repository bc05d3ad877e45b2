// A pilot learns how much light from each cell of the map arrives at the places of a scene, for the
// strategy `visibility` (lights/strategies/visibility.h).
#pragma once

#include <memory>

#include "lights/strategies/visibility.h"
#include "wavefront/frame.h"
#include "wavefront/pilot_reports.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Returns `strategy` as a pilot of the frame has taught it, or null if it is not one that learns.
// What is learnt depends on neither threads nor wave, nor on which part of the film or which
// samples the frame has. Statistics of the workers stay as they are, and no rays are recorded.
std::unique_ptr<VisibilityStrategy> LearnVisibility(const FrameView& frame,
                                                    const EnvStrategy& strategy, WorkerPool& pool,
                                                    PilotCounts& counts);

}  // namespace skywave
