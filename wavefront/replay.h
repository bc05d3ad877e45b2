// The ceiling: the rays of a frame, in the order in which it traced them, through Embree and
// nothing else. What a frame takes longer is the renderer's own.
#pragma once

#include <vector>

#include "wavefront/ray_recorder.h"
#include "wavefront/trace.h"

namespace skywave {

struct ReplayTime {
  double closest = 0, occlusion = 0;  // [s] wall clock on all threads
};

// Traces all recorded rays once with `backend` on `threads` threads, first the closest-hit batches,
// then the occlusion batches. Results are written to scratch memory and dropped.
ReplayTime Replay(RTCScene scene, Backend backend, const std::vector<RayRecorder>& recorders,
                  int threads);

}  // namespace skywave
