// Before each sample of the picture `vpl` traces the light paths that leave its virtual lights.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/records/virtual_lights.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// All sets have this in common.
struct VirtualLightPlan {
  std::uint64_t light_paths = 0;
  float distance = 0;
};

// Plans as many light paths as leave options.virtual_lights.count lights on average, at most
// kMostPathsAPhoton for each, and the distance, which is half of that between lights of a set if
// the user gives none. Both are found by light paths that are not used otherwise. The number of
// paths is fixed beforehand because ending at a number of lights would bias their flux.
VirtualLightPlan PlanVirtualLights(const FrameView& frame, WorkerPool& pool);

// Traces the lights of a sample of the picture. Bits depend on neither threads nor wave nor on the
// part of the film.
VirtualLights TraceVirtualLights(const FrameView& frame, const VirtualLightPlan& plan,
                                 std::uint32_t sample, WorkerPool& pool);

}  // namespace skywave
