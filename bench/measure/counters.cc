#include "bench/measure/counters.h"

#include <fmt/format.h>

namespace skywave {

std::vector<Counter> Counters(const Counted& counted) {
  const RenderStats& stats = counted.stats;
  std::vector<Counter> counters;
  const auto add = [&](std::string name, auto value) {
    counters.emplace_back(std::move(name), fmt::format("{}", value));
  };
  add("picture", fmt::format("{:016x}", counted.picture));
  add("scene", fmt::format("{:016x}", counted.scene));
  add("triangles", counted.triangles);
  add("geometry_bytes", counted.geometry_bytes);
  add("samples", stats.samples);
  add("waves", stats.waves);
  for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
    add(fmt::format("rays {}", kRayKindNames[kind]), stats.rays[kind]);
  }
  for (std::uint32_t i = 0; i < kCountedBounces && stats.bounces[i].rows > 0; ++i) {
    add(fmt::format("bounce {} rows", i),
        fmt::format("{} of {}", stats.bounces[i].rows, stats.bounces[i].capacity));
  }
  for (std::uint32_t i = 0; i < kKernels; ++i) {
    const LaneCount& lanes = stats.lanes[i];
    if (lanes.active == 0) continue;
    add(fmt::format("lanes {}", ToString(Kernel(i))),
        fmt::format("{} of {}", lanes.active, fmt::join(lanes.issued, " ")));
  }
  add("clamped_samples", stats.clamped_samples);
  add("invalid_samples", stats.invalid_samples);
  for (const StrategyTable& table : counted.tables) {
    add("table_bytes " + table.name, table.bytes);
  }
  return counters;
}

std::vector<Counter> Counters(const SuiteResult& result) {
  return Counters({.picture = result.found.hash,
                   .scene = result.scene_hash,
                   .triangles = result.triangles,
                   .geometry_bytes = result.geometry_bytes,
                   .stats = result.speed.first.stats,
                   .tables = result.tables});
}

}  // namespace skywave
