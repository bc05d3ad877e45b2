#include "bench/measure/hardware_events.h"

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <utility>

namespace skywave {

ProcessEvent::ProcessEvent(std::uint32_t type, std::uint64_t config) {
  perf_event_attr attributes = {};
  attributes.size = sizeof attributes;
  attributes.type = type;
  attributes.config = config;
  attributes.read_format = PERF_FORMAT_TOTAL_TIME_ENABLED | PERF_FORMAT_TOTAL_TIME_RUNNING;
  attributes.inherit = 1;
  attributes.exclude_kernel = 1;  // what users may ask for
  attributes.exclude_hv = 1;
  file_ = int(::syscall(SYS_perf_event_open, &attributes, 0, -1, -1, PERF_FLAG_FD_CLOEXEC));
}

ProcessEvent::~ProcessEvent() {
  if (file_ >= 0) ::close(file_);
}

std::optional<double> ProcessEvent::Read() const {
  struct {
    std::uint64_t value, enabled, running;
  } counted;
  if (file_ < 0 || ::read(file_, &counted, sizeof counted) != sizeof counted) return {};
  if (counted.running == 0) return 0;
  return double(counted.value) * (double(counted.enabled) / double(counted.running));
}

HardwareWatch::HardwareWatch()
    : instructions_(PERF_TYPE_HARDWARE, PERF_COUNT_HW_INSTRUCTIONS),
      cycles_(PERF_TYPE_HARDWARE, PERF_COUNT_HW_CPU_CYCLES),
      cache_misses_(PERF_TYPE_HARDWARE, PERF_COUNT_HW_CACHE_MISSES) {}

HardwareWatch::Counts HardwareWatch::Read() const {
  return {instructions_.Read(), cycles_.Read(), cache_misses_.Read()};
}

void HardwareWatch::End() {
  const Counts end = Read();
  for (std::size_t i = 0; i < end.size(); ++i) {
    if (begin_[i] && end[i]) sums_[i] = sums_[i].value_or(0) + (*end[i] - *begin_[i]);
  }
}

std::optional<HardwareCounts> HardwareWatch::Take() {
  const Counts sums = std::exchange(sums_, {});
  if (!sums[0] || !sums[1] || !(*sums[1] > 0)) return {};
  return HardwareCounts{*sums[0], *sums[1], sums[2]};
}

}  // namespace skywave
