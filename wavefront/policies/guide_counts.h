// A frame reports this about a pilot: that which guided its light paths
// (wavefront/records/emission_guide.h), or that which taught its strategy visibility
// (wavefront/policies/visibility_pilot.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace skywave {

struct GuideCounts {
  std::uint64_t paths = 0,
                samples = 0;  // paths of the pilot; what they found: guide samples or rays
  std::size_t bytes = 0;      // size of the tables
  double seconds = 0;         // wall clock
};

// How a candidate of the strategy `auto` has done in the pilot that chose.
struct CandidateScore {
  std::string name;
  double variance = 0;  // of the mean of the pilot's samples, relative to its square
  double cost = 0;      // of a sample [rays]
};

// What the pilot of the strategy `auto` has chosen (wavefront/policies/strategy_pilot.h).
struct StrategyChoice {
  std::string chosen;
  std::vector<CandidateScore> scores;
  double seconds = 0;  // wall clock
};

}  // namespace skywave
