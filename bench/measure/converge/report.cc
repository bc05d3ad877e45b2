#include "bench/measure/converge/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/granted.h"
#include "base/json.h"
#include "base/version.h"
#include "bench/measure/revision.h"
#include "wavefront/option_names.h"

namespace skywave {
namespace {

std::string_view KindText(const Crossing& time) {
  constexpr std::string_view kNames[] = {"inside", "before", "beyond"};
  return kNames[time.kind];
}

// Infinity and NaN, which JSON does not have, become null.
nlohmann::ordered_json JsonInterval(const Interval& interval) {
  return {interval.low, interval.high};
}

nlohmann::ordered_json JsonNumber(std::optional<double> value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json JsonRung(const Rung& rung, ErrorMeasure measure) {
  const std::vector<double> errors = rung.errors(measure);
  nlohmann::ordered_json json = {
      {"samples_per_pixel", rung.samples_per_pixel},
      {"seconds", Median(rung.seconds())},
      {"error", Mean(errors)},
      {"error_interval", JsonInterval(MeanInterval(errors))},
      {"squared_bias", rung.split.squared_bias},
      {"squared_bias_error", rung.split.squared_bias_error},
      {"biased", rung.split.biased()},
      {"variance", rung.split.variance},
      {"squared_bias_over_variance", rung.split.squared_bias / rung.split.variance},
      {"variance_seconds", rung.split.variance * Median(rung.seconds())}};
  for (const MeasuredRun& run : rung.runs) {
    json["runs"].push_back({{"seed", run.seed},
                            {"seconds", run.seconds},
                            {"mse", run.error.mse},
                            {"relative_mse", run.error.relative_mse},
                            {"mean_absolute", run.error.mean_absolute},
                            {"psnr_db", run.error.psnr},
                            {"squared_distance", 3 * run.error.mse},
                            {"squared_channel_sum", run.error.squared_channel_sum},
                            {"thesis_luminance", run.error.thesis_luminance}});
  }
  return json;
}

Plot PlotOver(const ConvergeReport& report, bool over_time) {
  const std::string measure(ToString(report.settings.measure));
  Plot plot = {.title = fmt::format("{}: {} against {}", report.scene, measure,
                                    over_time ? "render time" : "samples"),
               .x_label = over_time ? "render time [s]" : "samples per pixel",
               .y_label = measure,
               .series = {},
               .levels = {{"target", report.summary.target}}};
  if (const auto noise = report.reference.noise(report.settings.measure)) {
    plot.levels.push_back({"noise of the reference", *noise});
  }
  for (const Contestant& contestant : report.contestants) {
    PlotSeries series = {.name = contestant.name, .points = {}};
    for (const Rung& rung : contestant.ladder) {
      const std::vector<double> errors = rung.errors(report.settings.measure);
      const Interval interval = MeanInterval(errors);
      series.points.push_back(
          {.x = over_time ? Median(rung.seconds()) : double(rung.samples_per_pixel),
           .y = Mean(errors),
           .low = interval.low,
           .high = interval.high});
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

// Hints at the number of samples whose noise would be a tenth of the error; empty if the number of
// samples that `noise` comes from is unknown. `measured` is error and noise together.
std::string EnoughSamples(std::uint32_t samples, double noise, double measured) {
  if (samples == 0) return "";
  const double error = std::max(measured - noise, 0.1 * measured);
  return fmt::format(", about {:.0f}",
                     std::exp2(std::ceil(std::log2(10 * samples * noise / error))));
}

}  // namespace

std::vector<std::string> FindWarnings(const ConvergeReport& report) {
  std::vector<std::string> warnings;
  const ErrorMeasure measure = report.settings.measure;
  double smallest = std::numeric_limits<double>::infinity();
  for (const Contestant& contestant : report.contestants) {
    for (const Rung& rung : contestant.ladder) {
      smallest = std::min(smallest, Mean(rung.errors(measure)));
    }
  }
  const std::optional<double> noise = report.reference.noise(measure);
  if (!noise) {
    warnings.push_back(
        "the noise of the reference is unknown (no file of --save-reference): what is called bias "
        "may be its noise");
  } else if (*noise > 0.1 * smallest) {
    warnings.push_back(fmt::format(
        "the reference's own {} of {:.3g} is more than a tenth of the smallest error, {:.3g}: "
        "{} --reference-spp{}",
        ToString(measure), *noise, smallest,
        report.reference_source == "auto" ? "take more" : "keep one of more",
        EnoughSamples(report.reference_samples, *noise, smallest)));
  }
  return warnings;
}

std::string JsonText(const ConvergeReport& report) {
  const RenderOptions& options = report.job->options();
  const ErrorMeasure measure = report.settings.measure;
  nlohmann::ordered_json json;
  json["schema"] = "skywave-converge-2";
  json["version"] = Version();
  json["revision"] = GitRevision();
  if (!report.command.empty()) json["command"] = report.command;
  json["settings"] = {{"width", options.width},
                      {"height", options.height},
                      {"light_samples", options.light_samples},
                      {"max_depth", options.max_depth},
                      {"mis", options.mis},
                      {"filter", ToString(options.filter)},
                      {"threads", ThreadsFor(options.threads)},
                      {"wave", options.wave},
                      {"backend", ToString(options.backend)},
                      {"seed", options.seed},
                      {"repeats", report.settings.repeats},
                      {"measure", ToString(measure)}};
  json["scene"] = {{"name", report.scene},
                   {"hash", fmt::format("{:016x}", report.job->scene_hash())},
                   {"triangles", report.job->geometry().triangle_count()}};
  json["seconds"] = {{"load", report.job->times().load}, {"build", report.job->times().build}};
  json["reference"] = {
      {"source", report.reference_source},
      {"integrator", report.reference_integrator
                         ? nlohmann::ordered_json(ToString(*report.reference_integrator))
                         : nlohmann::ordered_json(nullptr)},
      {"samples_per_pixel", report.reference_samples},
      {"seconds", report.reference_seconds},
      {"mse", JsonNumber(report.reference.mse)},
      {"relative_mse", JsonNumber(report.reference.relative_mse)}};
  json["target"] = {{"error", report.summary.target}, {"from_first", report.summary.from_first}};
  for (std::size_t i = 0; i < report.contestants.size(); ++i) {
    const Contestant& contestant = report.contestants[i];
    const TimeToTarget& time = report.summary.times[i];
    nlohmann::ordered_json strategy = {
        {"strategy", contestant.specification},
        {"integrator", ToString(contestant.method.integrator)},
        {"unbiased", contestant.unbiased()},
        {"table_seconds", contestant.table_seconds},
        {"table_bytes", contestant.method.strategy->table_bytes()},
        {"time_to_target",
         {{"seconds", time.time.x},
          {"place", KindText(time.time)},
          {"interval", JsonInterval(time.interval)}}},
        {"speed_up",
         {{"factor", time.speed_up}, {"interval", JsonInterval(time.speed_up_interval)}}}};
    for (const Rung& rung : contestant.ladder)
      strategy["budgets"].push_back(JsonRung(rung, measure));
    json["strategies"].push_back(std::move(strategy));
  }
  json["warnings"] = report.warnings;
  return JsonText(json, 2);
}

std::vector<Plot> Plots(const ConvergeReport& report) {
  return {PlotOver(report, true), PlotOver(report, false)};
}

}  // namespace skywave
