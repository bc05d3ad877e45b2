// What pilots have done before a frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// What a pilot has taught a policy.
struct PilotCounts {
  std::string_view policy, found;  // its name; what it learns from, as a plural
  std::uint64_t paths = 0;         // of the pilot; 0: there was none
  std::uint64_t samples = 0;       // how many of what it learns from the paths have found
  std::size_t bytes = 0;           // size of the tables
  double seconds = 0;              // wall clock
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

struct PilotReports {
  std::vector<PilotCounts> counts;      // of each pilot that has taught
  std::vector<StrategyChoice> choices;  // of each strategy that was `auto`

  // What a policy was taught; without paths if no pilot has taught it.
  PilotCounts of(std::string_view policy) const {
    for (const PilotCounts& some : counts) {
      if (some.policy == policy) return some;
    }
    return {};
  }
};

}  // namespace skywave
