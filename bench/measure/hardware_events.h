// What the processors count while a process runs, where the system lets it ask
// (perf_event_open(2)): instructions, cycles, misses of the last cache.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace skywave {

// Of measured periods together, of all threads, outside the kernel.
struct HardwareCounts {
  double instructions = 0, cycles = 0;
  std::optional<double> cache_misses;
  double instructions_per_cycle() const { return instructions / cycles; }
};

// One event of this process: of the thread that makes it, and of all threads that are started
// later.
class ProcessEvent {
 public:
  // `type` and `config` are those of perf_event_attr.
  ProcessEvent(std::uint32_t type, std::uint64_t config);
  ProcessEvent(const ProcessEvent&) = delete;
  ProcessEvent& operator=(const ProcessEvent&) = delete;
  ~ProcessEvent();
  // Returns the count so far, scaled up where the processor counted other events in between;
  // nothing if it is not counted.
  std::optional<double> Read() const;

 private:
  int file_;
};

// Sums what is counted in periods. It is made before the threads that are to be counted.
class HardwareWatch {
 public:
  HardwareWatch();
  void Begin() { begin_ = Read(); }
  void End();
  // Returns the sums since the last call; nothing if the processor's events cannot be had.
  std::optional<HardwareCounts> Take();

 private:
  using Counts = std::array<std::optional<double>, 3>;
  Counts Read() const;

  ProcessEvent instructions_, cycles_, cache_misses_;
  Counts begin_, sums_;
};

}  // namespace skywave
