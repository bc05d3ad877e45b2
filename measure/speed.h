// How fast a job renders, and how fast Embree alone traces the same rays. Nothing is averaged here:
// every repetition is kept, so that a reader can judge the spread.
#pragma once

#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

#include "wavefront/job.h"
#include "wavefront/render.h"
#include "wavefront/replay.h"

namespace skywave {

struct SpeedSettings {
  int repetitions = 5;
  std::vector<int> thread_counts;  // to render with, besides the job's own threads
  bool replay = true;              // false: renders alone
};

// Wall clock of each repetition [s].
struct ReplaySeconds {
  std::vector<double> closest, occlusion;
};
struct ThreadSeconds {
  int threads;
  std::vector<double> render;
};

inline constexpr int kReplayCalls = int(std::size(kBackends));
inline constexpr RayOrder kReplayOrders[] = {RayOrder::kTraced, RayOrder::kWave, RayOrder::kFrame};
inline constexpr int kRayOrders = int(std::size(kReplayOrders));
// Calls worth replaying with sorted rays: where the order is not the traced one, the others have
// no times.
inline constexpr bool IsReplayed(RayOrder order, Backend backend) {
  return order == RayOrder::kTraced || backend == Backend::kStream || backend == Backend::kSingle;
}

struct Speed {
  FrameResult first;           // the frame that recorded its rays: counters, not times
  std::vector<double> render;  // [s] wall clock
  std::vector<std::array<double, kStages>> stages;         // [s] summed over workers
  ReplaySeconds replay[kRayOrders][kReplayCalls];          // empty: not replayed
  std::vector<ThreadSeconds> scaling;                      // ascending; the job's own too
  double load_average_before = 0, load_average_after = 0;  // of the last minute

  double render_seconds() const;  // median
  // The least time that Embree takes for the rays in this order: the medians of the best call for
  // closest hits and of the best for occlusion [s]. 0: not replayed.
  double best_replay_seconds(RayOrder order) const;
  // best_replay_seconds of the order of the frame over render_seconds; 0: not replayed.
  double embree_fraction() const;
  // How many times as fast as one thread `threads` are; 0: not measured.
  double speed_up(int threads) const;
};

// Renders a frame to `film`, which is empty, to record its rays and warm up; then renders and
// replays in turn, so that a slow minute slows all of them.
Speed MeasureSpeed(const RenderJob& job, const SpeedSettings& settings, Film& film);

// Processes waiting for a processor, over the last minute; negative: unknown.
double LoadAverage();

}  // namespace skywave
