// A replay sends the rays of a frame, in the order in which it traced them, through Embree and
// nothing else, which is the ceiling of its speed. The rest of a frame's time is the renderer's
// own.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "wavefront/rays/ray_recorder.h"
#include "wavefront/rays/trace.h"

namespace skywave {

struct ReplayTime {
  std::array<double, kRayKinds> seconds = {};  // in Embree, the mean over the threads
  // Rays that hit something; they are the same for every backend, order and number of threads.
  std::array<std::uint64_t, kRayKinds> hits = {};
};

// Traces all recorded rays once with `backend` on `threads` threads, one kind after the other, so
// that each has its own time. Hits are written to scratch memory, counted and dropped. Backends
// that do not read columns are charged for loading and storing them, as a render over columns is.
ReplayTime Replay(RTCScene scene, Backend backend, const std::vector<RayRecorder>& recorders,
                  int threads);

// Recorded rays are ordered in one of these orders before a replay.
enum class RayOrder {
  kTraced,  // as the frame traced them
  kWave,    // sorted within each batch: what a renderer could do without other waves
  kFrame    // sorted over the frame, in batches of 2048: what ordering could gain at most
};

// Returns the recorded rays, those of each kind by octant of the direction, then along a Morton
// curve through the bounding box of all origins. Sorting is not timed, so the gain of a replay is
// an upper bound.
std::vector<RayRecorder> OrderRays(const std::vector<RayRecorder>& recorders, RayOrder order);

}  // namespace skywave
