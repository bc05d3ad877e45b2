// The options that a caller gives to the scene readers.
#pragma once

#include <cstddef>

namespace skywave {

struct ReadOptions {
  // Turns every omission or approximation into an InputError instead of a warning.
  bool strict = false;
  // Files that grow beyond this by instances or subdivision are refused, so that a small file
  // cannot exhaust the memory. [triangles] 2^27 triangles are about 5 GB of positions and indices.
  std::size_t max_triangles = std::size_t{1} << 27;
};

}  // namespace skywave
