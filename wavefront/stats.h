// A render counts and times these. Every worker has its own; they are added up at the end.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <vector>

#include "wavefront/rays/lanes.h"
#include "wavefront/rays/ray_recorder.h"

namespace skywave {

// Stages are listed in the order in which a path reaches them.
enum class Stage : std::uint32_t {
  kGenerate,
  kIntersect,
  kPartition,
  kEscape,
  kSurface,
  kLightSample,
  kEvaluate,
  kShadow,
  kAccumulate,
  kScatter,
  kPhotons,  // stored and looked up
  kFilm
};
inline constexpr std::uint32_t kStages = 12;
std::string_view ToString(Stage stage);

// This counts the rows that entered a bounce, over all waves, and the rows that the waves had room
// for.
struct BounceOccupancy {
  std::uint64_t rows = 0, capacity = 0;
};

inline constexpr std::uint32_t kCountedBounces = 64;  // deeper ones count as the last

struct RenderStats {
  std::array<double, kStages> stage_seconds = {};  // summed over workers
  // Seconds of the stages intersect and shadow, by the rays that they traced.
  std::array<double, kRayKinds> trace_seconds = {};
  std::array<std::uint64_t, kRayKinds> rays = {};
  std::array<BounceOccupancy, kCountedBounces> bounces = {};
  std::array<LaneCount, kKernels> lanes = {};
  std::uint64_t waves = 0, samples = 0;
  std::uint64_t clamped_samples = 0, invalid_samples = 0;  // see Film::Add; the rim included

  RenderStats& operator+=(const RenderStats& other);
  double busy_seconds() const;
  std::uint64_t total_rays() const { return rays[0] + rays[1] + rays[2]; }
};

// Splits a worker's time into stages: each lap goes to the stage that has just run.
class StageClock {
 public:
  explicit StageClock(RenderStats& stats) : stats_(stats), last_(Now()) {}
  void Lap(Stage stage) { stats_.stage_seconds[static_cast<std::uint32_t>(stage)] += Lap(); }
  // The same for a stage that traced rays of one kind.
  void Lap(Stage stage, RayKind kind) {
    const double seconds = Lap();
    stats_.stage_seconds[static_cast<std::uint32_t>(stage)] += seconds;
    stats_.trace_seconds[static_cast<std::uint32_t>(kind)] += seconds;
  }

 private:
  static std::chrono::steady_clock::time_point Now() { return std::chrono::steady_clock::now(); }
  double Lap() {
    const auto now = Now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }
  RenderStats& stats_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace skywave
