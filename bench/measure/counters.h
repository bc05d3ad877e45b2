// Counts of a render that depend on neither time nor threads: rays, rows, lanes, bytes and hashes.
// With the same options they are the same on every machine with AVX2, so a gate can compare them to
// the last digit.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/measure/suite.h"

namespace skywave {

// A counter and its value as text: "bounce 1 rows", "503444 of 518144".
using Counter = std::pair<std::string, std::string>;

// What is counted; `tables` may be empty.
struct Counted {
  std::uint64_t picture = 0, scene = 0;  // hashes
  std::size_t triangles = 0, geometry_bytes = 0;
  const RenderStats& stats;
  std::span<const StrategyTable> tables = {};
};

// Returns the counters in a fixed order.
std::vector<Counter> Counters(const Counted& counted);
std::vector<Counter> Counters(const SuiteResult& result);

}  // namespace skywave
