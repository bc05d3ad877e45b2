#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/version.h"
#include "bench/measure/counters.h"
#include "bench/measure/statistics.h"
#include "cli/bench/report.h"
#include "cli/print.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

class Lines {
 public:
  template <class... T>
  void operator()(fmt::format_string<T...> format, T&&... values) {
    text_ += fmt::format(format, std::forward<T>(values)...) + "\n";
  }
  void Add(const std::string& text) { text_ += text; }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// Formats a rate [Mrays/s], or a dash if there is none.
std::string Rate(double value) { return value > 0 ? fmt::format("{:.2f}", value) : "-"; }

void WriteLanes(const LaneCounts& lanes, std::uint32_t width, Lines& line) {
  std::string text;
  int column = 0;
  for (std::uint32_t i = 0; i < kKernels; ++i) {
    if (lanes[i].active == 0) continue;
    if (column++ % 3 == 0) text += "\n ";
    text += fmt::format(" {:<28}{:>5.1f}%", ToString(Kernel(i)), 100 * lanes[i].utilisation(width));
  }
  line("  lanes in use, of vectors of {}:{}", width, text);
}

void WriteScene(const SuiteResult& result, std::uint32_t lanes, Lines& line) {
  const Speed& speed = result.speed;
  const RenderStats& stats = speed.first.stats;
  const auto samples = double(std::max<std::uint64_t>(stats.samples, 1));
  line("\n{}, {} x {}, {} samples a pixel, picture: {}", result.scene.name, result.scene.width,
       result.scene.height, result.scene.samples_per_pixel, ToString(result.check));
  line("  load {:.3f} s, build {:.3f} s, tables {:.3f} s, render {}, write {:.3f} s",
       result.times.load, result.times.build, result.times.tables, RenderText(speed),
       result.write_seconds);
  line("  {:.3f} Msamples/s, {:.3f} Mrays/s, {:.2f} rays a path, peak memory {:.0f} MiB",
       result.msamples_per_second(), result.mrays_per_second(),
       double(stats.total_rays()) / samples, result.peak_memory_bytes / (1 << 20));
  line.Add(HardwareText(speed));
  line.Add(RayText(speed));
  line("  {:<13}{:>8}{:>14}", "stage", "share", "ns a sample");
  for (std::uint32_t i = 0; i < kStages; ++i) {
    const double stage = speed.stage_seconds(Stage(i));
    line("  {:<13}{:>7.1f}%{:>14.2f}", ToString(Stage(i)),
         100 * stage / std::max(speed.busy_seconds(), 1e-12), stage / samples * 1e9);
  }
  WriteLanes(stats.lanes, lanes, line);
  std::string occupancy;
  for (const BounceOccupancy& bounce : stats.bounces) {
    if (bounce.rows == 0) break;
    occupancy += fmt::format(" {:.0f}%", 100 * double(bounce.rows) / double(bounce.capacity));
  }
  line("  wave occupancy by bounce:{}", occupancy);
  for (const ThreadSeconds& count : speed.scaling) {
    line("  {:>3} threads {:>10.4f} s, {:.2f} times one", count.threads, Median(count.render),
         speed.speed_up(count.threads));
  }
  line.Add(ReplayText(speed));
}

}  // namespace

std::vector<std::pair<std::string_view, double>> Figures(const SuiteSummary& summary) {
  return {{"msamples_per_s", summary.msamples_per_s},
          {"mrays_per_s", summary.mrays_per_s},
          {"embree_fraction", summary.embree_fraction},
          {"scaling_2", summary.scaling_2}};
}

std::string SummaryLine(const SuiteSummary& summary) {
  std::string text = "SUMMARY";
  for (const auto& [key, value] : Figures(summary)) {
    if (value > 0) text += fmt::format(" {}={:.3f}", key, value);
  }
  return text + "\n";
}

std::string NotMeasured(const SuiteReport& report) {
  std::vector<std::string_view> missing;
  for (const auto& [key, value] : Figures(Summarize(report.results))) {
    if (!(value > 0)) missing.push_back(key);
  }
  if (missing.empty()) return "";
  return fmt::format("not measured: {} ({})\n", fmt::join(missing, ", "),
                     report.replayed ? "less than two threads" : "--renders-only");
}

std::string Headline(const SuiteReport& report) {
  const SuiteSummary summary = Summarize(report.results);
  const Machine& machine = report.machine;
  return fmt::format(
      "{:.3f} Msamples/s on {} threads: the {} suite, skywave {}, revision {}\n"
      "{}, kernels {}, Embree {}, {}, {}\n",
      summary.msamples_per_s, report.results.front().speed.first.threads,
      report.full ? "full" : "quick", Version(), machine.revision, machine.processor,
      machine.instructions, machine.embree_config, machine.compiler, machine.build);
}

std::string SuiteText(const SuiteReport& report) {
  Lines line;
  for (const SuiteResult& result : report.results) {
    WriteScene(result, ShownLanes(report.machine), line);
  }
  line("\n{} bytes a path in flight, {} paths a wave, load average {:.2f} to {:.2f}",
       kWorkerBytesPerRow, report.options.wave, report.results.front().speed.load_average_before,
       report.results.back().speed.load_average_after);
  const std::vector<StrategyTable>& tables = report.results.front().tables;
  if (!tables.empty()) line("{:<16}{:>14}{:>10}", "table of", "bytes", "build s");
  for (const StrategyTable& table : tables) {
    line("{:<16}{:>14}{:>10.3f}", table.name, table.bytes, table.seconds);
  }
  return line.text();
}

std::uint32_t ShownLanes(const Machine& machine) {
  return machine.lanes >= int(kLaneWidths.back()) ? kLaneWidths.back() : kLaneWidths.front();
}

std::string RenderText(const Speed& speed) {
  return fmt::format("{:.4f} s ({:.4f} to {:.4f}, {} times, deviation {:.1f} %)",
                     speed.render_seconds(),
                     *std::min_element(speed.render.begin(), speed.render.end()),
                     *std::max_element(speed.render.begin(), speed.render.end()),
                     speed.render.size(), 100 * speed.deviation());
}

void PrintDoubts(const Speed& speed, std::string_view scene) {
  for (const std::string& doubt : speed.doubts()) Print(stderr, "note: {}: {}\n", scene, doubt);
}

void PrintGovernor(const Machine& machine) {
  if (machine.governor.empty() || machine.governor == "performance") return;
  Print(stderr,
        "note: the governor of the processors is {}, so times depend on what ran before; "
        "`cpupower frequency-set -g performance` keeps the clock up\n",
        machine.governor);
}

std::string HardwareText(const Speed& speed) {
  if (!speed.hardware) return "";
  const HardwareCounts& counts = *speed.hardware;
  return fmt::format("  {:.2f} instructions a cycle{}\n", counts.instructions_per_cycle(),
                     counts.cache_misses
                         ? fmt::format(", {:.2f} cache misses per 1000 of them",
                                       1000 * *counts.cache_misses / counts.instructions)
                         : "");
}

std::string RayText(const Speed& speed) {
  const RenderStats& stats = speed.first.stats;
  const auto samples = double(std::max<std::uint64_t>(stats.samples, 1));
  Lines line;
  line("  {:<13}{:>8}{:>12}{:>15}{:>12}  {}", "rays", "a path", "Mrays/s", "while tracing", "raw",
       "by");
  for (std::uint32_t i = 0; i < kRayKinds; ++i) {
    const auto kind = RayKind(i);
    const double raw = speed.raw_mrays_per_second(kind);
    line("  {:<13}{:>8.2f}{:>12}{:>15}{:>12}  {}", kRayKindNames[i],
         double(stats.rays[i]) / samples, Rate(speed.mrays_per_second(kind)),
         Rate(speed.traced_mrays_per_second(kind)), Rate(raw),
         raw > 0 ? ToString(speed.best_replay(RayOrder::kTraced, kind).call) : "-");
  }
  return line.text();
}

std::string ReplayText(const Speed& speed) {
  if (!speed.replayed(RayOrder::kTraced)) return "";
  Lines line;
  line("  {:<10}{:<8}{:>12}{:>12}{:>12}", "order", "call", "camera [s]", "bounce [s]",
       "shadow [s]");
  for (int order = 0; order < kRayOrders; ++order) {
    for (int call = 0; call < kReplayCalls; ++call) {
      const ReplaySeconds& replay = speed.replay[order][call];
      if (replay[0].empty()) continue;
      line("  {:<10}{:<8}{:>12.4f}{:>12.4f}{:>12.4f}", kRayOrderNames[order],
           ToString(kBackends[call]), Median(replay[0]), Median(replay[1]), Median(replay[2]));
    }
  }
  const double traced = speed.best_replay_seconds(RayOrder::kTraced);
  line(
      "  ceiling {:.4f} s, {:.3f} of the render; sorted within waves {:.2f} times as fast, over "
      "the frame {:.2f} times",
      traced, speed.embree_fraction(), traced / speed.best_replay_seconds(RayOrder::kWave),
      traced / speed.best_replay_seconds(RayOrder::kFrame));
  return line.text();
}

std::string CountersText(const std::vector<SuiteResult>& results) {
  Lines line;
  line("bytes_per_path {}", kWorkerBytesPerRow);
  for (const SuiteResult& result : results) {
    for (const auto& [name, value] : Counters(result)) {
      line("{} {} {}", result.scene.name, name, value);
    }
  }
  return line.text();
}

}  // namespace skywave
