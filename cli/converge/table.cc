#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/converge/report.h"

namespace skywave {
namespace {

// Formats a crossing, as a bound if it is outside the curve.
std::string TimeText(const Crossing& time) {
  constexpr const char* kSigns[] = {"", "<= ", "> "};
  return fmt::format("{}{:.4g}", kSigns[time.kind], time.x);
}

std::string IntervalText(const Interval& interval) {
  if (std::isnan(interval.low) || std::isnan(interval.high)) return "-";
  return fmt::format("{:.3g} to {:.3g}", interval.low, interval.high);
}

// Ends outside the curve are not numbers.
std::string TimeIntervalText(const Interval& interval) {
  const auto end = [](double value) {
    if (value == 0) return std::string("before");
    return std::isinf(value) ? std::string("beyond") : fmt::format("{:.3g}", value);
  };
  if (std::isnan(interval.low) || std::isnan(interval.high)) return "-";
  if (interval.low == interval.high) return end(interval.low);
  return end(interval.low) + " to " + end(interval.high);
}

// Formats the speed-up, as a bound if the other time is one; a dash if the first time is one.
std::string SpeedUpText(const Crossing& first, const Crossing& other) {
  if (first.kind != Crossing::kInside) return "-";
  constexpr const char* kSigns[] = {"", ">= ", "< "};
  return fmt::format("{}{:.3g}", kSigns[other.kind], first.x / other.x);
}

std::string BiasText(const Rung& rung) {
  const ErrorSplit& split = rung.split;
  if (!split.biased()) return "none found";
  return fmt::format("{:.3g} = {:.2g} x variance", split.squared_bias,
                     split.squared_bias / split.variance);
}

}  // namespace

std::string Introduction(const ConvergeReport& report) {
  const std::optional<double> noise = report.reference.noise(report.settings.measure);
  return fmt::format(
      "reference: {}, {}, own {} {}\n"
      "medians of the time and means of the error of {} runs; 95 % intervals\n",
      report.reference_source,
      report.reference_samples > 0 ? fmt::format("{} samples a pixel", report.reference_samples)
                                   : "samples unknown",
      ToString(report.settings.measure), noise ? fmt::format("{:.3g}", *noise) : "unknown",
      report.settings.repeats);
}

TextTable BudgetTable(const ConvergeReport& report) {
  const ErrorMeasure measure = report.settings.measure;
  TextTable table = {{"", "samples", "time [s]", std::string(ToString(measure)), "interval",
                      "variance", "variance x time", "squared bias"}};
  for (const Contestant& contestant : report.contestants) {
    for (const Rung& rung : contestant.ladder) {
      const std::vector<double> errors = rung.errors(measure);
      const double seconds = Median(rung.seconds());
      table.push_back({contestant.name, fmt::format("{}", rung.samples_per_pixel),
                       fmt::format("{:.4g}", seconds), fmt::format("{:.3g}", Mean(errors)),
                       IntervalText(MeanInterval(errors)),
                       fmt::format("{:.3g}", rung.split.variance),
                       fmt::format("{:.3g}", rung.split.variance * seconds), BiasText(rung)});
    }
  }
  return table;
}

std::string TargetText(const ConvergeReport& report) {
  return fmt::format("time to {} {:.3g}{}", ToString(report.settings.measure),
                     report.summary.target,
                     report.summary.from_first ? ", the first one's at its largest budget" : "");
}

TextTable TargetTable(const ConvergeReport& report) {
  TextTable table = {
      {"", "tables [s]", "time [s]", "interval", "speed-up", "interval", "in expectation"}};
  for (std::size_t i = 0; i < report.contestants.size(); ++i) {
    const Contestant& contestant = report.contestants[i];
    const TimeToTarget& time = report.summary.times[i];
    table.push_back(
        {contestant.name, fmt::format("{:.4g}", contestant.table_seconds), TimeText(time.time),
         TimeIntervalText(time.interval), SpeedUpText(report.summary.times[0].time, time.time),
         IntervalText(time.speed_up_interval), contestant.unbiased() ? "exact" : "biased"});
  }
  return table;
}

}  // namespace skywave
