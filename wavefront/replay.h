// The ceiling: the rays of a frame, in the order in which it traced them, through Embree and
// nothing else. What a frame takes longer is the renderer's own.
#pragma once

#include <cstdint>
#include <vector>

#include "wavefront/ray_recorder.h"
#include "wavefront/trace.h"

namespace skywave {

struct ReplayTime {
  double closest = 0, occlusion = 0;  // [s] in Embree, the mean over the threads
  // Rays that hit something: the same for every backend, order and number of threads.
  std::uint64_t closest_hits = 0, occlusion_hits = 0;
};

// Traces all recorded rays once with `backend` on `threads` threads, first the closest-hit batches,
// then the occlusion batches. Hits are written to scratch memory, counted and dropped. Backends
// that do not read columns are charged for loading and storing them, as a render over columns is.
ReplayTime Replay(RTCScene scene, Backend backend, const std::vector<RayRecorder>& recorders,
                  int threads);

// How recorded rays are ordered before a replay.
enum class RayOrder {
  kTraced,  // as the frame traced them
  kWave,    // sorted within each batch: what a renderer could do without other waves
  kFrame    // sorted over the frame, in batches of 2048: what ordering could gain at most
};

// The recorded rays by octant of the direction, then along a Morton curve through the bounding box
// of all origins. Sorting is not timed: what a replay gains is an upper bound.
std::vector<RayRecorder> OrderRays(const std::vector<RayRecorder>& recorders, RayOrder order);

}  // namespace skywave
