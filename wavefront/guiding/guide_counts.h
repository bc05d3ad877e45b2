// A frame reports this about a pilot: that which guided its light paths
// (wavefront/guiding/emission_guide.h), or that which taught its strategy visibility
// (wavefront/guiding/visibility_pilot.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace skywave {

struct GuideCounts {
  std::uint64_t paths = 0,
                samples = 0;  // paths of the pilot; what they found: guide samples or rays
  std::size_t bytes = 0;      // size of the tables
  double seconds = 0;         // wall clock
};

}  // namespace skywave
