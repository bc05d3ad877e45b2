// Light sampling made slower on purpose, to prove that the gates can fail: scripts/gate_selftest.sh
// builds with -DSKYWAVE_SLOWDOWN=PERCENT. No other build includes this file.
#pragma once

#include <cstdint>

namespace skywave {

// Takes about SKYWAVE_SLOWDOWN percent of the time that light samples of `n` surfaces take.
inline void SlowDown(std::uint32_t n) {
  // Multiplications that wait for each other; the number is what the light samples of `importance`
  // cost on a machine with AVX-512 at 4 cycles a step.
  constexpr std::uint64_t kStepsPerSample = 25;
  std::uint64_t x = n;
  for (std::uint64_t step = n * kStepsPerSample * SKYWAVE_SLOWDOWN / 100; step > 0; --step) {
    x = x * 6364136223846793005u + 1442695040888963407u;
  }
  // Else the compiler would see that nobody wants x.
  asm volatile("" : : "r"(x));
}

}  // namespace skywave
