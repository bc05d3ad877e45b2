// A frame reports this about the pilot that guided its light paths
// (wavefront/guiding/emission_guide.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace skywave {

struct GuideCounts {
  std::uint64_t paths = 0, samples = 0;  // paths of the pilot; guide samples that they found
  std::size_t bytes = 0;                 // size of the tables
  double seconds = 0;                    // wall clock
};

}  // namespace skywave
