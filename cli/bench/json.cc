#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/version.h"
#include "bench/measure/bench_record.h"
#include "bench/measure/json_input.h"
#include "cli/bench/report.h"
#include "fmt/format.h"
#include "wavefront/worker.h"

namespace skywave {
using nlohmann::ordered_json;

ordered_json Measured(double value) {
  return value > 0 ? ordered_json(value) : ordered_json(nullptr);
}

namespace {

template <class Value>
ordered_json OrNull(const std::optional<Value>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json Json(const SuiteSummary& summary) {
  ordered_json json;
  for (const auto& [key, value] : Figures(summary)) json[std::string(key)] = Measured(value);
  return json;
}

ordered_json Json(const SuiteResult& result) {
  const RenderStats& stats = result.speed.first.stats;
  const double samples = double(stats.samples), seconds = result.speed.render_seconds();
  ordered_json json;
  json["name"] = result.scene.name;
  json["width"] = result.scene.width;
  json["height"] = result.scene.height;
  json["samples_per_pixel"] = result.scene.samples_per_pixel;
  json["scene_hash"] = fmt::format("{:016x}", result.scene_hash);
  json["picture"] = {{"hash", fmt::format("{:016x}", result.found.hash)},
                     {"expected", fmt::format("{:016x}", result.scene.expected.hash)},
                     {"check", ToString(result.check)},
                     {"block_difference", BlockDifference(result.scene.expected, result.found)}};
  json["msamples_per_s"] = result.msamples_per_second();
  json["mrays_per_s"] = result.mrays_per_second();
  json["embree_fraction"] = Measured(result.speed.embree_fraction());
  json["seconds"] = {{"load", result.times.load},
                     {"build", result.times.build},
                     {"tables", result.times.tables},
                     {"render", seconds},
                     {"write", result.write_seconds}};
  json["samples"] = stats.samples;
  json["waves"] = stats.waves;
  for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
    json["rays"][std::string(kRayKindNames[kind])] = {
        {"count", stats.rays[kind]},
        {"per_path", double(stats.rays[kind]) / samples},
        {"mrays_per_s", result.speed.mrays_per_second(RayKind(kind))},
        {"traced_mrays_per_s", Measured(result.speed.traced_mrays_per_second(RayKind(kind)))},
        {"raw_mrays_per_s", Measured(result.speed.raw_mrays_per_second(RayKind(kind)))}};
  }
  const double busy = std::max(result.speed.busy_seconds(), 1e-12);
  for (std::uint32_t i = 0; i < kStages; ++i) {
    const double stage = result.speed.stage_seconds(Stage(i));
    json["stages"][std::string(ToString(Stage(i)))] = {{"ns_per_sample", stage / samples * 1e9},
                                                       {"share", stage / busy}};
  }
  for (std::uint32_t i = 0; i < kKernels; ++i) {
    const LaneCount& lanes = stats.lanes[i];
    if (lanes.active == 0) continue;
    ordered_json& to = json["lanes"][ToString(Kernel(i))];
    to["active"] = lanes.active;
    for (std::size_t width = 0; width < kLaneWidths.size(); ++width) {
      to[fmt::format("issued_{}", kLaneWidths[width])] = lanes.issued[width];
    }
  }
  for (const BounceOccupancy& bounce : stats.bounces) {
    if (bounce.rows == 0) break;
    json["bounces"].push_back({{"rows", bounce.rows}, {"capacity", bounce.capacity}});
  }
  json["triangles"] = result.triangles;
  json["bytes"] = {{"geometry", result.geometry_bytes}, {"peak", result.peak_memory_bytes}};
  json["tables"];  // null unless measured
  for (const StrategyTable& table : result.tables) {
    json["tables"][table.name] = {{"bytes", table.bytes}, {"seconds", table.seconds}};
  }
  json.update(Json(result.speed));
  return json;
}

}  // namespace

ordered_json Json(const Machine& machine) {
  ordered_json json = {{"processor", machine.processor},
                       {"microcode", machine.microcode},
                       {"governor", machine.governor},
                       {"virtual_machine", machine.virtual_machine},
                       {"processors", machine.processors},
                       {"memory_bytes", machine.memory_bytes},
                       {"system", machine.system},
                       {"compiler", machine.compiler},
                       {"build", machine.build},
                       {"revision", machine.revision},
                       {"instructions", machine.instructions},
                       {"lanes", machine.lanes},
                       {"embree_config", machine.embree_config}};
  for (const auto& [name, version] : machine.libraries) json["libraries"][name] = version;
  return json;
}

ordered_json Json(const Speed& speed) {
  ordered_json json;
  json["deviation"] = {{"relative", speed.deviation()},
                       {"limit", Measured(speed.deviation_limit)},
                       {"reached", speed.steady()}};
  json["conditions"] = {{"waiting", OrNull(speed.conditions.waiting)},
                        {"stolen", OrNull(speed.conditions.stolen)},
                        {"throttled", OrNull(speed.conditions.throttled)}};
  json["hardware"];  // null unless counted
  if (speed.hardware) {
    json["hardware"] = {{"instructions", speed.hardware->instructions},
                        {"cycles", speed.hardware->cycles},
                        {"instructions_per_cycle", speed.hardware->instructions_per_cycle()},
                        {"cache_misses", OrNull(speed.hardware->cache_misses)}};
  }
  json["repetitions"]["render"] = speed.render;
  json["repetitions"]["processor"] = speed.processor;
  for (const auto& stages : speed.stages) {
    ordered_json& all = json["repetitions"]["stages"];
    for (std::uint32_t i = 0; i < kStages; ++i) {
      all[std::string(ToString(Stage(i)))].push_back(stages[i]);
    }
  }
  for (const auto& traces : speed.traces) {
    ordered_json& all = json["repetitions"]["tracing"];
    for (std::uint32_t i = 0; i < kRayKinds; ++i) {
      all[std::string(kRayKindNames[i])].push_back(traces[i]);
    }
  }
  for (const ThreadSeconds& count : speed.scaling) {
    json["scaling"].push_back({{"threads", count.threads},
                               {"render", count.render},
                               {"speed_up", Measured(speed.speed_up(count.threads))}});
  }
  json["load_average"] = {speed.load_average_before, speed.load_average_after};
  if (!speed.replayed(RayOrder::kTraced)) return json;
  for (int order = 0; order < kRayOrders; ++order) {
    ordered_json& to = json["replay"][std::string(kRayOrderNames[order])];
    for (int call = 0; call < kReplayCalls; ++call) {
      const ReplaySeconds& replay = speed.replay[order][call];
      if (replay[0].empty()) continue;
      ordered_json& seconds = to["seconds"][std::string(ToString(kBackends[call]))];
      for (std::uint32_t i = 0; i < kRayKinds; ++i) {
        seconds[std::string(kRayKindNames[i])] = replay[i];
      }
    }
    for (std::uint32_t i = 0; i < kRayKinds; ++i) {
      to["best_call"][std::string(kRayKindNames[i])] =
          ToString(speed.best_replay(kReplayOrders[order], RayKind(i)).call);
    }
    to["best_seconds"] = speed.best_replay_seconds(kReplayOrders[order]);
    to["gain"] = speed.best_replay_seconds(RayOrder::kTraced) /
                 speed.best_replay_seconds(kReplayOrders[order]);
  }
  return json;
}

ordered_json Json(const SuiteReport& report) {
  ordered_json json;
  json["schema"] = kSuiteSchema;
  json["version"] = Version();
  json["suite"] = report.full ? "full" : "quick";
  json["summary"] = Json(Summarize(report.results));
  json["machine"] = Json(report.machine);
  json["settings"] = {{"threads", report.results.front().speed.first.threads},
                      {"wave", report.options.wave},
                      {"backend", ToString(report.options.backend)},
                      {"repetitions", report.repetitions},
                      {"bytes_per_path", kWorkerBytesPerRow}};
  for (const SuiteResult& result : report.results) json["scenes"].push_back(Json(result));
  return json;
}

HistoryEntry ReadHistory(const std::string& path) {
  return {.name = std::filesystem::path(path).filename().string(),
          .summary = SummaryOf(ReadJson(path), path)};
}

}  // namespace skywave
