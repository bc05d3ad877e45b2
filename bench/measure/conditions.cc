#include "bench/measure/conditions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <set>

namespace skywave {
namespace {

// Returns the folders in a folder; none if it cannot be read.
std::vector<std::filesystem::path> Folders(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    found.push_back(at->path());
  }
  return found;
}

// Threads that end in a period are missing at its end: all that render live as long as the process.
void ReadThreads(const std::string& root, ConditionCounts& counts) {
  for (const std::filesystem::path& thread : Folders(root + "/proc/self/task")) {
    std::ifstream file(thread / "schedstat");
    std::uint64_t ran = 0, waited = 0;
    if (!(file >> ran >> waited)) continue;
    counts.ran = counts.ran.value_or(0) + ran;
    counts.waited = counts.waited.value_or(0) + waited;
  }
}

// The first line is "cpu", then ticks: user, nice, system, idle, iowait, irq, softirq, steal; what
// follows is a part of the first two.
void ReadProcessors(const std::string& root, ConditionCounts& counts) {
  std::ifstream file(root + "/proc/stat");
  std::string name;
  std::array<std::uint64_t, 8> ticks = {};
  if (!(file >> name) || name != "cpu") return;
  std::uint64_t sum = 0;
  for (std::uint64_t& value : ticks) {
    if (!(file >> value)) return;
    sum += value;
  }
  counts.ticks = sum;
  counts.stolen = ticks.back();
}

std::vector<std::filesystem::path> Processors(const std::string& root) {
  return Folders(root + "/sys/devices/system/cpu");
}

void ReadHeat(const std::string& root, ConditionCounts& counts) {
  for (const std::filesystem::path& processor : Processors(root)) {
    std::ifstream file(processor / "thermal_throttle/core_throttle_count");
    std::uint64_t count = 0;
    if (file >> count) counts.throttled = counts.throttled.value_or(0) + count;
  }
}

// Adds what was counted from `begin` to `end`. Counters that run backwards, as those of processors
// that were taken away, have counted nothing.
void AddCounted(const std::optional<std::uint64_t>& begin, const std::optional<std::uint64_t>& end,
                std::optional<std::uint64_t>& sum) {
  if (!begin || !end) return;
  sum = sum.value_or(0) + (*end > *begin ? *end - *begin : 0);
}

std::optional<double> Share(const std::optional<std::uint64_t>& part, std::uint64_t whole) {
  if (!part || whole == 0) return {};
  return double(*part) / double(whole);
}

}  // namespace

ConditionCounts ReadConditions(const std::string& root) {
  ConditionCounts counts;
  ReadThreads(root, counts);
  ReadProcessors(root, counts);
  ReadHeat(root, counts);
  return counts;
}

std::string ReadGovernors(const std::string& root) {
  std::set<std::string> found;
  for (const std::filesystem::path& processor : Processors(root)) {
    std::ifstream file(processor / "cpufreq/scaling_governor");
    std::string governor;
    if (file >> governor) found.insert(governor);
  }
  return fmt::format("{}", fmt::join(found, ","));
}

void ConditionsWatch::End() {
  const ConditionCounts end = ReadConditions(root_);
  AddCounted(begin_.ran, end.ran, sums_.ran);
  AddCounted(begin_.waited, end.waited, sums_.waited);
  AddCounted(begin_.ticks, end.ticks, sums_.ticks);
  AddCounted(begin_.stolen, end.stolen, sums_.stolen);
  AddCounted(begin_.throttled, end.throttled, sums_.throttled);
}

Conditions ConditionsWatch::conditions() const {
  return {.waiting = Share(sums_.waited, sums_.waited.value_or(0) + sums_.ran.value_or(0)),
          .stolen = Share(sums_.stolen, sums_.ticks.value_or(0)),
          .throttled = sums_.throttled};
}

std::vector<std::string> Conditions::disturbances() const {
  std::vector<std::string> found;
  if (waiting.value_or(0) > kMostWaiting) {
    found.push_back(
        fmt::format("its threads waited {:.1f} % of their time for processors", 100 * *waiting));
  }
  if (stolen.value_or(0) > kMostStolen) {
    found.push_back(
        fmt::format("other virtual machines had {:.1f} % of the processors' time", 100 * *stolen));
  }
  if (throttled.value_or(0) > 0) {
    const std::string times = *throttled == 1 ? "once" : fmt::format("{} times", *throttled);
    found.push_back("heat slowed cores " + times);
  }
  return found;
}

}  // namespace skywave
