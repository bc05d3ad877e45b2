#include "bench/measure/render_report.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <nlohmann/json.hpp>

#include "base/granted.h"
#include "base/json.h"
#include "base/version.h"
#include "wavefront/option_names.h"

namespace skywave {
namespace {

double PeakMemoryMib() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024;
}

// Returns whose limit the number of threads is.
std::string ThreadsFrom(const RenderReport& report) {
  return report.job->options().threads > 0 ? "option" : GrantedHere().threads_from;
}

double Rate(double count, double seconds) { return seconds > 0 ? count / seconds * 1e-6 : 0; }

}  // namespace

std::string Table(const RenderReport& report) {
  const RenderStats& stats = report.frame.stats;
  const JobTimes& times = report.job->times();
  const double seconds = report.frame.seconds;
  const std::string limit = ThreadsFrom(report);
  std::string text;
  const auto line = [&]<class... T>(fmt::format_string<T...> format, T&&... values) {
    text += fmt::format(format, std::forward<T>(values)...) + "\n";
  };
  line(
      "load {:.3f} s, build {:.3f} s, tables {:.3f} s, render {:.3f} s, write {:.3f} s, "
      "peak memory {:.0f} MiB",
      times.load, times.build, times.tables, seconds, report.write_seconds, PeakMemoryMib());
  line("{:.3f} Msamples/s, {:.3f} Mrays/s, {:.2f} rays a sample, {} threads{}",
       Rate(double(stats.samples), seconds), Rate(double(stats.total_rays()), seconds),
       double(stats.total_rays()) / double(std::max<std::uint64_t>(stats.samples, 1)),
       report.frame.threads,
       limit == "machine" || limit == "option" ? "" : fmt::format(" ({})", limit));
  const std::uint32_t got = report.frame.samples_per_pixel,
                      asked = report.job->options().samples_per_pixel;
  const std::string noise = report.noise ? fmt::format(", noise {:.4g}", *report.noise) : "";
  const double in_mean = report.frame.mean_samples_per_pixel;
  if (report.adaptive) {
    line("{:.1f} samples per pixel on average, {} at most{}; {:.1f} % of the blocks need no more",
         in_mean, got, noise, 100 * report.frame.ended_blocks);
  } else if (got < asked || report.noise) {
    line("{} of {} samples per pixel{}", got, asked, noise);
  }
  for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
    line("  {:<13}{:>10.3f} Mrays/s{:>14} rays", kRayKindNames[kind],
         Rate(double(stats.rays[kind]), seconds), stats.rays[kind]);
  }
  for (const PilotCounts& pilot : report.frame.pilots.counts) {
    line("  {}: {} {} of {} paths, in {:.3f} s, {:.1f} MiB", pilot.policy, pilot.samples,
         pilot.found, pilot.paths, pilot.seconds, double(pilot.bytes) / (1 << 20));
  }
  for (const StrategyChoice& choice : report.frame.pilots.choices) {
    std::string scores;
    for (const CandidateScore& score : choice.scores) {
      scores += fmt::format("{}{} {:.4g}", scores.empty() ? "" : ", ", score.name,
                            score.variance * score.cost);
    }
    line("  auto: {}, in {:.3f} s; variance x cost: {}", choice.chosen, choice.seconds, scores);
  }
  const IntegratorDescriptor& integrator = Describe(report.job->options().integrator);
  if (integrator.describe_passes != nullptr) {
    line("  {}", integrator.describe_passes(report.frame.photons));
  }
  line("  {:<13}{:>8}{:>14}", "stage", "share", "ns a sample");
  const double busy = std::max(stats.busy_seconds(), 1e-12);
  for (std::uint32_t i = 0; i < kStages; ++i) {
    line("  {:<13}{:>7.1f}%{:>14.2f}", ToString(Stage(i)), 100 * stats.stage_seconds[i] / busy,
         stats.stage_seconds[i] / double(std::max<std::uint64_t>(stats.samples, 1)) * 1e9);
  }
  text += "  wave occupancy by bounce:";
  for (const BounceOccupancy& bounce : stats.bounces) {
    if (bounce.rows == 0) break;
    text += fmt::format(" {:.0f}%", 100 * double(bounce.rows) / double(bounce.capacity));
  }
  text += "\n";
  if (stats.clamped_samples + stats.invalid_samples > 0) {
    line("  {} samples were brighter than the film holds and clamped, {} were not numbers",
         stats.clamped_samples, stats.invalid_samples);
  }
  return text;
}

std::string JsonText(const RenderReport& report) {
  const RenderStats& stats = report.frame.stats;
  const JobTimes& times = report.job->times();
  const RenderOptions& options = report.job->options();
  const double seconds = report.frame.seconds;
  nlohmann::ordered_json json;
  json["schema"] = "skywave-render-stats-1";
  json["version"] = Version();
  json["settings"] = {{"width", options.width},
                      {"height", options.height},
                      {"samples_per_pixel", options.samples_per_pixel},
                      {"integrator", ToString(options.integrator)},
                      {"max_depth", options.max_depth},
                      {"strategy", report.job->strategy().name()},
                      {"threads", report.frame.threads},
                      {"threads_from", ThreadsFrom(report)},
                      {"wave", options.wave},
                      {"backend", ToString(options.backend)}};
  json["scene"] = {{"hash", fmt::format("{:016x}", report.job->scene_hash())},
                   {"triangles", report.job->geometry().triangle_count()},
                   {"geometry_bytes", report.job->geometry().bytes()},
                   {"strategy_table_bytes", report.job->strategy().table_bytes()}};
  json["seconds"] = {{"load", times.load},
                     {"build", times.build},
                     {"tables", times.tables},
                     {"render", seconds},
                     {"render_processor", report.frame.processor_seconds},
                     {"write", report.write_seconds}};
  json["warnings"] = report.job->warnings();
  json["notes"] = report.job->notes();
  json["peak_memory_mib"] = PeakMemoryMib();
  json["samples"] = stats.samples;
  json["rendered_samples_per_pixel"] = report.frame.samples_per_pixel;
  if (report.adaptive) {
    json["mean_samples_per_pixel"] = report.frame.mean_samples_per_pixel;
    json["ended_blocks"] = report.frame.ended_blocks;
  }
  if (report.noise) json["noise"] = *report.noise;
  json["msamples_per_s"] = Rate(double(stats.samples), seconds);
  json["mrays_per_s"] = Rate(double(stats.total_rays()), seconds);
  for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
    json["rays"][std::string(kRayKindNames[kind])] = {
        {"count", stats.rays[kind]}, {"mrays_per_s", Rate(double(stats.rays[kind]), seconds)}};
  }
  for (std::uint32_t i = 0; i < kStages; ++i) {
    json["stages"][std::string(ToString(Stage(i)))] = {
        {"thread_seconds", stats.stage_seconds[i]},
        {"share", stats.stage_seconds[i] / std::max(stats.busy_seconds(), 1e-12)}};
  }
  for (const PilotCounts& pilot : report.frame.pilots.counts) {
    json[std::string(pilot.policy)] = {{"paths", pilot.paths},
                                       {"samples", pilot.samples},
                                       {"table_bytes", pilot.bytes},
                                       {"seconds", pilot.seconds}};
  }
  for (const StrategyChoice& choice : report.frame.pilots.choices) {
    nlohmann::ordered_json scores = nlohmann::ordered_json::object();
    for (const CandidateScore& score : choice.scores) {
      scores[score.name] = {{"variance", score.variance}, {"cost", score.cost}};
    }
    json["choices"].push_back(
        {{"chosen", choice.chosen}, {"seconds", choice.seconds}, {"scores", scores}});
  }
  if (const PhotonCounts& photons = report.frame.photons; photons.light_paths > 0) {
    json["photons"] = {
        {"indirect", photons.indirect},       {"caustic", photons.caustic},
        {"light_paths", photons.light_paths}, {"map_bytes", photons.bytes},
        {"radius", photons.radius},           {"caustic_radius", photons.caustic_radius},
        {"seconds", photons.seconds}};
  }
  json["waves"] = stats.waves;
  for (const BounceOccupancy& bounce : stats.bounces) {
    if (bounce.rows == 0) break;
    json["occupancy"].push_back(double(bounce.rows) / double(bounce.capacity));
  }
  json["clamped_samples"] = stats.clamped_samples;
  json["invalid_samples"] = stats.invalid_samples;
  return JsonText(json, 2);
}

}  // namespace skywave
