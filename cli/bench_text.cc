#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/bench_report.h"
#include "measure/statistics.h"
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

std::string Number(double value, int digits = 3) {
  return value > 0 ? fmt::format("{:.{}f}", value, digits) : "nan";
}

void WriteScene(const SuiteResult& result, Lines& line) {
  const Speed& speed = result.speed;
  const RenderStats& stats = speed.first.stats;
  const double seconds = speed.render_seconds();
  const auto samples = double(std::max<std::uint64_t>(stats.samples, 1));
  line("\n{}, {} x {}, {} samples a pixel, picture: {}", result.scene.name, result.scene.width,
       result.scene.height, result.scene.samples_per_pixel, ToString(result.check));
  line(
      "  load {:.3f} s, build {:.3f} s, tables {:.3f} s, render {:.4f} s ({:.4f} to {:.4f}), "
      "write {:.3f} s",
      result.times.load, result.times.build, result.times.tables, seconds,
      *std::min_element(speed.render.begin(), speed.render.end()),
      *std::max_element(speed.render.begin(), speed.render.end()), result.write_seconds);
  line("  {:.3f} Msamples/s, {:.3f} Mrays/s, {:.2f} rays a path, peak memory {:.0f} MiB",
       result.msamples_per_second(), result.mrays_per_second(),
       double(stats.total_rays()) / samples, result.peak_memory_bytes / (1 << 20));
  for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
    line("  {:<13}{:>10.3f} Mrays/s{:>8.2f} a path", kRayKindNames[kind],
         double(stats.rays[kind]) / seconds * 1e-6, double(stats.rays[kind]) / samples);
  }
  line("  {:<13}{:>8}{:>14}", "stage", "share", "ns a sample");
  for (std::uint32_t i = 0; i < kStages; ++i) {
    const double stage = StageSeconds(speed, i);
    line("  {:<13}{:>7.1f}%{:>14.2f}", ToString(Stage(i)),
         100 * stage / std::max(BusySeconds(speed), 1e-12), stage / samples * 1e9);
  }
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

double StageSeconds(const Speed& speed, std::uint32_t stage) {
  std::vector<double> seconds;
  for (const auto& repetition : speed.stages) seconds.push_back(repetition[stage]);
  return Median(seconds);
}

double BusySeconds(const Speed& speed) {
  double sum = 0;
  for (std::uint32_t i = 0; i < kStages; ++i) sum += StageSeconds(speed, i);
  return sum;
}

std::string SummaryLine(const SuiteSummary& summary) {
  return fmt::format("SUMMARY msamples_per_s={} mrays_per_s={} embree_fraction={} scaling_2={}\n",
                     Number(summary.msamples_per_s), Number(summary.mrays_per_s),
                     Number(summary.embree_fraction), Number(summary.scaling_2));
}

std::string Headline(const SuiteReport& report) {
  const SuiteSummary summary = Summarize(report.results);
  const Machine& machine = report.machine;
  return fmt::format(
      "{} Msamples/s on {} threads: the {} suite, skywave {}\n{}, kernels {}, Embree {}, {}, {}\n",
      Number(summary.msamples_per_s), report.results.front().speed.first.threads,
      report.full ? "full" : "quick", SKYWAVE_VERSION, machine.processor, machine.instructions,
      machine.embree_config, machine.compiler, machine.build);
}

std::string SuiteText(const SuiteReport& report) {
  Lines line;
  for (const SuiteResult& result : report.results) WriteScene(result, line);
  line("\n{} bytes a path in flight, {} paths a wave, load average {:.2f} to {:.2f}",
       kWorkerBytesPerRow, report.options.wave, report.results.front().speed.load_average_before,
       report.results.back().speed.load_average_after);
  line("{:<16}{:>14}{:>10}", "table of", "bytes", "build s");
  for (const StrategyTable& table : report.results.front().tables) {
    line("{:<16}{:>14}{:>10.3f}", table.name, table.bytes, table.seconds);
  }
  return line.text();
}

std::string ReplayText(const Speed& speed) {
  if (speed.best_replay_seconds(RayOrder::kTraced) == 0) return "";
  Lines line;
  line("  {:<10}{:<8}{:>14}{:>16}", "rays", "call", "closest [s]", "occlusion [s]");
  for (int order = 0; order < kRayOrders; ++order) {
    for (int call = 0; call < kReplayCalls; ++call) {
      const ReplaySeconds& replay = speed.replay[order][call];
      if (replay.closest.empty()) continue;
      line("  {:<10}{:<8}{:>14.4f}{:>16.4f}", kRayOrderNames[order], ToString(kBackends[call]),
           Median(replay.closest), Median(replay.occlusion));
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
    const RenderStats& stats = result.speed.first.stats;
    const auto& name = result.scene.name;
    line("{} picture {:016x}", name, result.found.hash);
    line("{} scene {:016x}", name, result.scene_hash);
    line("{} triangles {}", name, result.triangles);
    line("{} geometry_bytes {}", name, result.geometry_bytes);
    line("{} samples {}", name, stats.samples);
    line("{} waves {}", name, stats.waves);
    for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
      line("{} rays {} {}", name, kRayKindNames[kind], stats.rays[kind]);
    }
    for (std::uint32_t i = 0; i < kCountedBounces && stats.bounces[i].rows > 0; ++i) {
      line("{} bounce {} rows {} of {}", name, i, stats.bounces[i].rows, stats.bounces[i].capacity);
    }
    line("{} clamped_samples {}", name, stats.clamped_samples);
    line("{} invalid_samples {}", name, stats.invalid_samples);
    for (const StrategyTable& table : result.tables) {
      line("{} table_bytes {} {}", name, table.name, table.bytes);
    }
  }
  return line.text();
}

}  // namespace skywave
