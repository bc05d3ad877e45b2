// The random numbers of the oracle: PCG32 (O'Neill 2014), one stream per pixel.
#pragma once

#include <cstdint>

namespace skywave {

class OracleRandom {
 public:
  OracleRandom(std::uint64_t seed, std::uint64_t stream) : increment_(stream << 1 | 1) {
    Word();
    state_ += seed;
    Word();
  }
  // Uniform in [0, 1), multiples of 2^-32.
  double operator()() { return Word() * 0x1p-32; }

 private:
  std::uint32_t Word() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005u + increment_;
    const auto mixed = std::uint32_t((old >> 18 ^ old) >> 27), turn = std::uint32_t(old >> 59);
    return mixed >> turn | mixed << (-turn & 31);
  }
  std::uint64_t state_ = 0, increment_;
};

}  // namespace skywave
