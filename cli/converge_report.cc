#include "cli/converge_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace skywave {
namespace {

// A crossing as a bound where it is one.
std::string TimeText(const Crossing& time) {
  constexpr const char* kSigns[] = {"", "<= ", "> "};
  return fmt::format("{}{:.4g}", kSigns[time.kind], time.x);
}

std::string_view KindText(const Crossing& time) {
  constexpr std::string_view kNames[] = {"inside", "before", "beyond"};
  return kNames[time.kind];
}

std::string IntervalText(const Interval& interval) {
  if (std::isnan(interval.low) || std::isnan(interval.high)) return "-";
  return fmt::format("{:.3g} to {:.3g}", interval.low, interval.high);
}

// Ends that lie outside of the curve are no numbers.
std::string TimeIntervalText(const Interval& interval) {
  const auto end = [](double value) {
    if (value == 0) return std::string("before");
    return std::isinf(value) ? std::string("beyond") : fmt::format("{:.3g}", value);
  };
  if (std::isnan(interval.low) || std::isnan(interval.high)) return "-";
  if (interval.low == interval.high) return end(interval.low);
  return end(interval.low) + " to " + end(interval.high);
}

std::string NumberText(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.3g}", value);
}

std::string BiasText(const Rung& rung) {
  const ErrorSplit& split = rung.split;
  if (!split.biased()) return "none found";
  return fmt::format("{:.3g} = {:.2g} x variance", split.squared_bias,
                     split.squared_bias / split.variance);
}

double VarianceSeconds(const Rung& rung) { return rung.split.variance * Median(rung.seconds()); }

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
      {"variance_seconds", VarianceSeconds(rung)}};
  for (const MeasuredRun& run : rung.runs) {
    json["runs"].push_back({{"seed", run.seed},
                            {"seconds", run.seconds},
                            {"mse", run.error.mse},
                            {"relative_mse", run.error.relative_mse},
                            {"mean_absolute", run.error.mean_absolute},
                            {"psnr_db", run.error.psnr},
                            {"thesis_euclidean", run.error.thesis_euclidean},
                            {"thesis_luminance", run.error.thesis_luminance}});
  }
  return json;
}

LogPlot PlotOver(const ConvergeReport& report, bool over_time) {
  const std::string measure(ToString(report.settings.measure));
  LogPlot plot = {.title = fmt::format("{}: {} against {}", report.scene, measure,
                                       over_time ? "render time" : "samples"),
                  .x_label = over_time ? "render time [s]" : "samples per pixel",
                  .y_label = measure,
                  .series = {},
                  .levels = {{"target", report.summary.target}}};
  if (const auto noise = report.reference.noise(report.settings.measure)) {
    plot.levels.push_back({"noise of the reference", *noise});
  }
  for (const Contestant& contestant : report.contestants) {
    PlotSeries series = {.name = contestant.specification, .points = {}};
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
        "take more --reference-spp",
        ToString(measure), *noise, smallest));
  }
  return warnings;
}

std::string Table(const ConvergeReport& report) {
  const ErrorMeasure measure = report.settings.measure;
  const std::string error(ToString(measure));
  std::size_t name = 8;
  for (const Contestant& c : report.contestants) name = std::max(name, c.specification.size());
  std::string text;
  const auto line = [&]<class... T>(fmt::format_string<T...> format, T&&... values) {
    text += fmt::format(format, std::forward<T>(values)...) + "\n";
  };
  const auto noise = report.reference.noise(measure);
  line("reference: {}, {}, own {} {}", report.reference_source,
       report.reference_samples > 0 ? fmt::format("{} samples a pixel", report.reference_samples)
                                    : "samples unknown",
       error, noise ? fmt::format("{:.3g}", *noise) : "unknown");
  line("medians of the time and means of the error of {} runs; 95 % intervals\n",
       report.settings.repeats);
  line("{:<{}}  {:>7} {:>10} {:>12}  {:<22} {:>10} {:>10}  {}", "strategy", name, "spp", "time [s]",
       error, "interval", "variance", "var x time", "squared bias");
  for (const Contestant& contestant : report.contestants) {
    for (const Rung& rung : contestant.ladder) {
      const std::vector<double> errors = rung.errors(measure);
      line("{:<{}}  {:>7} {:>10.4g} {:>12.3g}  {:<22} {:>10.3g} {:>10.3g}  {}",
           contestant.specification, name, rung.samples_per_pixel, Median(rung.seconds()),
           Mean(errors), IntervalText(MeanInterval(errors)), rung.split.variance,
           VarianceSeconds(rung), BiasText(rung));
    }
  }
  line("\ntime to {} {:.3g}{}", error, report.summary.target,
       report.summary.from_first ? " (the first strategy's at its largest budget)" : "");
  line("{:<{}}  {:>10} {:>12}  {:<22} {:>9}  {:<22} {}", "strategy", name, "tables [s]", "time [s]",
       "interval", "speed-up", "interval", "in expectation");
  for (std::size_t i = 0; i < report.contestants.size(); ++i) {
    const Contestant& contestant = report.contestants[i];
    const TimeToTarget& time = report.summary.times[i];
    line("{:<{}}  {:>10.4g} {:>12}  {:<22} {:>9}  {:<22} {}", contestant.specification, name,
         contestant.table_seconds, TimeText(time.time), TimeIntervalText(time.interval),
         NumberText(time.speed_up), IntervalText(time.speed_up_interval),
         contestant.strategy->unbiased() ? "exact" : "biased");
  }
  return text;
}

nlohmann::ordered_json Json(const ConvergeReport& report) {
  const RenderOptions& options = report.job->options();
  const ErrorMeasure measure = report.settings.measure;
  nlohmann::ordered_json json;
  json["schema"] = "skywave-converge-1";
  json["version"] = SKYWAVE_VERSION;
  json["command"] = report.command;
  json["settings"] = {{"width", options.width},
                      {"height", options.height},
                      {"integrator", ToString(options.integrator)},
                      {"light_samples", options.light_samples},
                      {"max_depth", options.max_depth},
                      {"mis", options.mis},
                      {"filter", ToString(options.filter)},
                      {"threads", options.threads > 0 ? options.threads : AvailableThreads()},
                      {"wave", options.wave},
                      {"backend", ToString(options.backend)},
                      {"seed", options.seed},
                      {"repeats", report.settings.repeats},
                      {"measure", ToString(measure)}};
  json["scene"] = {{"name", report.scene},
                   {"hash", fmt::format("{:016x}", report.job->scene_hash())},
                   {"triangles", report.job->geometry().triangle_count()}};
  json["seconds"] = {{"load", report.job->times().load}, {"build", report.job->times().build}};
  json["reference"] = {{"source", report.reference_source},
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
        {"unbiased", contestant.strategy->unbiased()},
        {"table_seconds", contestant.table_seconds},
        {"table_bytes", contestant.strategy->table_bytes()},
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
  return json;
}

std::vector<LogPlot> Plots(const ConvergeReport& report) {
  return {PlotOver(report, true), PlotOver(report, false)};
}

}  // namespace skywave
