#include "wavefront/stats.h"

namespace skywave {

std::string_view ToString(Stage stage) {
  static constexpr std::string_view kNames[kStages] = {
      "generate", "intersect", "partition",  "escape",  "surface", "light sample",
      "evaluate", "shadow",    "accumulate", "scatter", "photons", "film"};
  return kNames[static_cast<std::uint32_t>(stage)];
}

RenderStats& RenderStats::operator+=(const RenderStats& other) {
  for (std::uint32_t i = 0; i < kStages; ++i) stage_seconds[i] += other.stage_seconds[i];
  for (std::uint32_t i = 0; i < kRayKinds; ++i) {
    rays[i] += other.rays[i];
    trace_seconds[i] += other.trace_seconds[i];
  }
  for (std::uint32_t i = 0; i < kKernels; ++i) lanes[i] += other.lanes[i];
  for (std::uint32_t i = 0; i < kCountedBounces; ++i) {
    bounces[i].rows += other.bounces[i].rows;
    bounces[i].capacity += other.bounces[i].capacity;
  }
  waves += other.waves;
  samples += other.samples;
  clamped_samples += other.clamped_samples;
  invalid_samples += other.invalid_samples;
  return *this;
}

double RenderStats::busy_seconds() const {
  double sum = 0;
  for (const double seconds : stage_seconds) sum += seconds;
  return sum;
}

}  // namespace skywave
