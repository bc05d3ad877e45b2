// A pilot learns which light arrives at the places of a scene from where, to guide paths.
#pragma once

#include <memory>

#include "wavefront/frame.h"
#include "wavefront/guiding/bounce_guide.h"
#include "wavefront/guiding/guide_counts.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Returns what a pilot of the frame has learnt, or null if there is nothing to learn. It depends on
// neither threads nor wave, nor on which part of the film or which samples the frame has.
std::unique_ptr<BounceGuide> LearnBounces(const FrameView& frame, WorkerPool& pool,
                                          GuideCounts& counts);

}  // namespace skywave
