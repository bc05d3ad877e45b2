// Measures wall-clock time for reports.
#pragma once

#include <chrono>

namespace skywave {

using Clock = std::chrono::steady_clock;

inline double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace skywave
