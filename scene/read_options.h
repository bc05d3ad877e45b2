// What the user allows the readers of scenes.
#pragma once

#include <cstddef>

namespace skywave {

struct ReadOptions {
  // Whatever would be left out or approximated is an InputError instead of a warning.
  bool strict = false;
  // Files that grow beyond this by instances or subdivision are refused, so that a small one cannot
  // exhaust the memory. [triangles] 2^27 are about 5 GB of positions and indices.
  std::size_t max_triangles = std::size_t{1} << 27;
};

}  // namespace skywave
