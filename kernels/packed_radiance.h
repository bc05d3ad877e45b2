// Radiance, or a color, in one word.
#pragma once

#include <cstdint>

namespace skywave {

// It takes four bytes, because lookups are random accesses and pay by the cache line: three
// mantissas of kMantissaBits bits, r lowest, and a common exponent above them (as in Radiance's
// RGBE). A channel is mantissa * 2^(exponent - kMaxExponent) times a unit that a map or a table has
// for all its words.
using PackedRadiance = std::uint32_t;
inline constexpr std::uint32_t kMantissaBits = 9;
inline constexpr std::uint32_t kMaxExponent = 31;

}  // namespace skywave
