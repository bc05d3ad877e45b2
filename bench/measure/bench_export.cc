#include "bench/measure/bench_export.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/granted.h"
#include "bench/measure/statistics.h"

namespace skywave {
namespace {

using nlohmann::ordered_json;

// A measure of Bencher; the ends of an unknown interval are left out.
ordered_json Metric(double value, const Interval& interval) {
  ordered_json metric = {{"value", value}};
  if (std::isfinite(interval.low) && std::isfinite(interval.high)) {
    metric["lower_value"] = interval.low;
    metric["upper_value"] = interval.high;
  }
  return metric;
}

// A rate is in inverse proportion to the time, and so are the ends of its interval.
ordered_json RateMetric(double count, double seconds, const Interval& interval) {
  return Metric(count / seconds, {count / interval.high, count / interval.low});
}

ordered_json Bmf(const BenchRecord& record) {
  ordered_json json = ordered_json::object();
  std::vector<double> rates;
  for (const SceneRecord& scene : record.scenes) {
    const double seconds = Mean(scene.render);
    const Interval interval = MeanInterval(scene.render);
    ordered_json& measures = json[scene.name];
    measures["latency"] = Metric(seconds * 1e9, {interval.low * 1e9, interval.high * 1e9});
    measures["throughput"] = RateMetric(scene.samples, seconds, interval);
    measures["rays-per-second"] = RateMetric(scene.rays, seconds, interval);
    rates.push_back(scene.samples / seconds);
  }
  if (rates.size() > 1) json[record.subject]["throughput"] = {{"value", GeometricMean(rates)}};
  return json;
}

// Returns the clock of the first processor [MHz] and whether it is scaled; 0 and false if unknown.
int ClockMhz() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("cpu MHz") && colon != std::string::npos) {
      return int(std::lround(std::strtod(line.c_str() + colon + 2, nullptr)));
    }
  }
  return 0;
}
bool ClockIsScaled() {
  std::ifstream file("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  std::string governor;
  return std::getline(file, governor) && governor != "performance";
}

ordered_json GoogleContext() {
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  double load[3] = {};
  const int known = ::getloadavg(load, 3);
  ordered_json loads = ordered_json::array();
  for (int i = 0; i < known; ++i) loads.push_back(load[i]);
  return {{"date", fmt::format("{:%FT%T+00:00}", fmt::gmtime(std::time(nullptr)))},
          {"host_name", host},
          {"executable", "skywave"},
          {"num_cpus", GrantedHere().threads},
          {"mhz_per_cpu", ClockMhz()},
          {"cpu_scaling_enabled", ClockIsScaled()},
          {"caches", ordered_json::array()},
          {"load_avg", std::move(loads)},
#ifdef NDEBUG
          {"library_build_type", "release"}};
#else
          {"library_build_type", "debug"}};
#endif
}

struct GoogleTimes {
  double real, cpu;  // [s]
};

// A time is in ms, but a coefficient of variation is a fraction.
void AddTimes(const GoogleTimes& times, double scale, ordered_json& entry) {
  entry["real_time"] = times.real * scale;
  entry["cpu_time"] = times.cpu * scale;
  entry["time_unit"] = "ms";
}

ordered_json Google(const BenchRecord& record) {
  ordered_json json;
  json["context"] = GoogleContext();
  ordered_json& all = json["benchmarks"] = ordered_json::array();
  for (std::size_t family = 0; family < record.scenes.size(); ++family) {
    const SceneRecord& scene = record.scenes[family];
    const std::vector<double>& real = scene.render;
    // Without times of the processor, those of the clock stand for them.
    const std::vector<double>& cpu =
        scene.processor.size() == real.size() ? scene.processor : scene.render;
    const auto entry = [&](const std::string& suffix, std::string_view type) {
      const std::string& name = scene.name;
      return ordered_json{
          {"name", name + suffix}, {"family_index", family}, {"per_family_instance_index", 0},
          {"run_name", name},      {"run_type", type},       {"repetitions", real.size()}};
    };
    for (std::size_t i = 0; i < real.size(); ++i) {
      ordered_json run = entry("", "iteration");
      run["repetition_index"] = i;
      run["threads"] = record.threads;
      run["iterations"] = 1;
      AddTimes({real[i], cpu[i]}, 1e3, run);
      run["items_per_second"] = scene.samples / real[i];
      all.push_back(std::move(run));
    }
    if (real.size() < 2) continue;
    std::vector<double> rates;
    for (const double seconds : real) rates.push_back(scene.samples / seconds);
    const auto aggregate = [&](const std::string& name, bool is_time, auto statistic) {
      ordered_json run = entry("_" + name, "aggregate");
      run["threads"] = record.threads;
      run["aggregate_name"] = name;
      run["aggregate_unit"] = is_time ? "time" : "percentage";
      run["iterations"] = real.size();
      AddTimes({statistic(real), statistic(cpu)}, is_time ? 1e3 : 1, run);
      run["items_per_second"] = statistic(rates);
      all.push_back(std::move(run));
    };
    using Values = std::vector<double>;
    aggregate("mean", true, [](const Values& values) { return Mean(values); });
    aggregate("median", true, [](const Values& values) { return Median(values); });
    aggregate("stddev", true, [](const Values& v) { return std::sqrt(SampleVariance(v)); });
    aggregate("cv", false, [](const Values& values) { return RelativeDeviation(values); });
  }
  return json;
}

}  // namespace

ordered_json Export(const BenchRecord& record, ExportFormat format) {
  return format == ExportFormat::kBmf ? Bmf(record) : Google(record);
}

}  // namespace skywave
