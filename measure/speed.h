// How fast a job renders, and how fast Embree alone traces the same rays. Nothing is averaged here:
// every repetition is kept, so that a reader can judge the spread.
#pragma once

#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

#include "job/job.h"
#include "wavefront/rays/replay.h"
#include "wavefront/render.h"

namespace skywave {

struct SpeedSettings {
  int repetitions = 5;
  std::vector<int> thread_counts;  // to render with, besides the job's own threads
  bool replay = true;              // false: renders alone
};

// Wall clock of each repetition, for each kind of rays [s].
using ReplaySeconds = std::array<std::vector<double>, kRayKinds>;
// A kind of rays by the call that is fastest for them.
struct BestReplay {
  Backend call;
  double seconds;  // median
};
struct ThreadSeconds {
  int threads;
  std::vector<double> render;
};

inline constexpr int kReplayCalls = int(std::size(kBackends));
inline constexpr RayOrder kReplayOrders[] = {RayOrder::kTraced, RayOrder::kWave, RayOrder::kFrame};
inline constexpr int kRayOrders = int(std::size(kReplayOrders));
// Calls worth replaying with sorted rays: where the order is not the traced one, arrays have no
// times.
inline constexpr bool IsReplayed(RayOrder order, Backend backend) {
  return order == RayOrder::kTraced || backend != Backend::kArray;
}

struct Speed {
  FrameResult first;           // the frame that recorded its rays: counters, not times
  std::vector<double> render;  // [s] wall clock
  std::vector<std::array<double, kStages>> stages;         // [s] summed over workers
  std::vector<std::array<double, kRayKinds>> traces;       // [s] likewise, of the rays in them
  ReplaySeconds replay[kRayOrders][kReplayCalls];          // empty: not replayed
  std::vector<ThreadSeconds> scaling;                      // ascending; the job's own too
  double load_average_before = 0, load_average_after = 0;  // of the last minute

  double render_seconds() const;  // median
  bool replayed(RayOrder order) const { return !replay[int(order)][0][0].empty(); }
  // Of an order that was replayed.
  BestReplay best_replay(RayOrder order, RayKind kind) const;
  // The least time that Embree takes for the rays in this order: the sum over their kinds, each by
  // its best call [s]. 0: not replayed.
  double best_replay_seconds(RayOrder order) const;
  // best_replay_seconds of the order of the frame over render_seconds; 0: not replayed.
  double embree_fraction() const;
  // Medians over the repetitions [s], summed over workers: of a stage, of all stages, and of the
  // tracing of one kind of rays in the render.
  double stage_seconds(Stage stage) const;
  double busy_seconds() const;
  double trace_seconds(RayKind kind) const;
  // Rays of a kind [Mrays/s]: over the whole render, so that the kinds add up; while they are
  // traced in the render, on all threads; raw, in the traced order. 0: none, or not replayed.
  double mrays_per_second(RayKind kind) const;
  double traced_mrays_per_second(RayKind kind) const;
  double raw_mrays_per_second(RayKind kind) const;
  // How many times as fast as one thread `threads` are; 0: not measured.
  double speed_up(int threads) const;
};

// Renders a frame to `film`, which is empty, to record its rays and warm up; then renders and
// replays in turn, so that a slow minute slows all of them.
Speed MeasureSpeed(const RenderJob& job, const SpeedSettings& settings, Film& film);

// Processes waiting for a processor, over the last minute; negative: unknown.
double LoadAverage();

}  // namespace skywave
