// What else a machine did while times were measured: the reasons for which they say less than their
// spread does.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace skywave {

// What the kernel has counted since the system or the process began.
struct ConditionCounts {
  // [ns] of the threads of this process: on a processor, and ready while others had it.
  std::optional<std::uint64_t> ran, waited;
  // Ticks of all processors: all of them, and those that went to other virtual machines.
  std::optional<std::uint64_t> ticks, stolen;
  std::optional<std::uint64_t> throttled;  // how often cores were slowed because they were hot
};

// Returns what the files of proc(5) and sysfs below `root` say ("/" is this machine); nothing for
// files that are not there or have another form.
ConditionCounts ReadConditions(const std::string& root = "/");

// Returns what the processors are governed by, "schedutil" say, each once; empty if nothing is
// known.
std::string ReadGovernors(const std::string& root = "/");

// Times are not to be trusted beyond these: other programs had processors for so much of the time
// that threads would have run; other virtual machines for so much of the time of all processors.
inline constexpr double kMostWaiting = 0.02, kMostStolen = 0.01;

// Of measured periods together; nothing: unknown.
struct Conditions {
  std::optional<double> waiting;  // share of the time in which threads ran or were ready to
  std::optional<double> stolen;   // share of the processors' time
  std::optional<std::uint64_t> throttled;

  // Returns what disturbed the times, each as half a sentence. Empty: nothing that is known.
  std::vector<std::string> disturbances() const;
};

// Sums what the kernel counts in periods that are measured.
class ConditionsWatch {
 public:
  explicit ConditionsWatch(std::string root = "/") : root_(std::move(root)) {}
  void Begin() { begin_ = ReadConditions(root_); }
  void End();
  Conditions conditions() const;

 private:
  std::string root_;
  ConditionCounts begin_, sums_;
};

}  // namespace skywave
