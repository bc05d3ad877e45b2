// Measures how fast a job renders, and how fast Embree alone traces the same rays. Every repetition
// is kept instead of an average, so that a reader can judge the spread.
#pragma once

#include <array>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "bench/measure/conditions.h"
#include "bench/measure/hardware_events.h"
#include "job/job.h"
#include "wavefront/rays/replay.h"
#include "wavefront/render.h"

namespace skywave {

struct SpeedSettings {
  int repetitions = 5;  // at least
  // Repetitions go on until the fastest renders have at most this relative standard deviation, or
  // kMostRepetitions times their number is reached. 0: they do not go on.
  double deviation = 0;
  std::vector<int> thread_counts;     // measured in addition to the job's own threads
  bool replay = true;                 // false: only renders
  HardwareWatch* hardware = nullptr;  // what the renders are counted with; null: they are not
};

// If times still scatter after this many times the repetitions, the machine is busy with something
// else, and more repetitions would not help.
inline constexpr int kMostRepetitions = 4;
// The limit of the Phoronix Test Suite.
inline constexpr double kDeviationLimit = 0.025;

// Wall clock of each repetition, per kind of rays [s].
using ReplaySeconds = std::array<std::vector<double>, kRayKinds>;
// The fastest call for one kind of rays.
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

struct Speed {
  FrameResult first;           // the frame that recorded its rays, for counters rather than times
  double deviation_limit = 0;  // SpeedSettings::deviation
  std::vector<double> render;  // [s] wall clock
  std::vector<double> processor;                      // [s] of all threads of the process meanwhile
  std::vector<std::array<double, kStages>> stages;    // [s] summed over workers
  std::vector<std::array<double, kRayKinds>> traces;  // [s] likewise, for the rays within them
  ReplaySeconds replay[kRayOrders][kReplayCalls];     // empty if not replayed
  std::vector<ThreadSeconds> scaling;                 // ascending, including the job's own threads
  double load_average_before = 0, load_average_after = 0;  // over the last minute
  Conditions conditions;                                   // of the renders
  std::optional<HardwareCounts> hardware;                  // likewise; nothing: not counted

  double render_seconds() const;  // median
  double deviation() const;       // relative standard deviation of the fastest renders (FastestOf)
  bool steady() const { return deviation_limit == 0 || deviation() <= deviation_limit; }
  // Returns why these times are not to be trusted, each as half a sentence; empty: no reason known.
  std::vector<std::string> doubts() const;
  bool replayed(RayOrder order) const { return !replay[int(order)][0][0].empty(); }
  // `order` must have been replayed.
  BestReplay best_replay(RayOrder order, RayKind kind) const;
  // Returns Embree's shortest time for the rays in this order: the sum over kinds, each with its
  // best call [s]. 0: not replayed.
  double best_replay_seconds(RayOrder order) const;
  // Returns best_replay_seconds in the frame's own order over render_seconds. 0: not replayed.
  double embree_fraction() const;
  // Return medians over the repetitions [s], summed over workers: of a stage, of all stages, and of
  // tracing one kind of rays in the render.
  double stage_seconds(Stage stage) const;
  double busy_seconds() const;
  double trace_seconds(RayKind kind) const;
  // Return rates of one kind of rays [Mrays/s]: over the whole render, so that the kinds add up;
  // while they are traced in the render, on all threads; and raw, in the traced order. 0: none, or
  // not replayed.
  double mrays_per_second(RayKind kind) const;
  double traced_mrays_per_second(RayKind kind) const;
  double raw_mrays_per_second(RayKind kind) const;
  // Returns the speed-up of `threads` over one thread. 0: not measured.
  double speed_up(int threads) const;
};

// Returns a doubt about `renders` that deviate by more than `limit`.
std::string UnsteadyText(std::size_t renders, double deviation, double limit);

// Renders a frame into `film`, which must be empty, to record its rays and warm up; then alternates
// renders and replays, so that a slow minute of the machine affects all of them.
Speed MeasureSpeed(const RenderJob& job, const SpeedSettings& settings, Film& film);

// Returns the number of processes waiting for a processor over the last minute. Negative: unknown.
double LoadAverage();

}  // namespace skywave
