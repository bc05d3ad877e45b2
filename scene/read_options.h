// The options that a caller gives to the scene readers.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace skywave {

struct ReadOptions {
  // Turns every omission or approximation into an InputError instead of a warning.
  bool strict = false;
  // Files that grow beyond this by instances or subdivision are refused, so that a small file
  // cannot exhaust the memory. [triangles] 2^27 triangles are about 5 GB of positions and indices.
  std::size_t max_triangles = std::size_t{1} << 27;
  // The moment at which an animated scene is read, frame / fps [s]. Unset: nodes are where the file
  // puts them without its animations.
  std::optional<double> frame;
  std::optional<double> fps;   // [1/s]; unset: kDefaultFps
  std::string animation = {};  // the only animation that moves something; empty: all do
};

inline constexpr double kDefaultFps = 24;

// Returns the moment in seconds, or nothing where no frame is asked for.
inline std::optional<double> TimeOf(const ReadOptions& options) {
  if (!options.frame) return std::nullopt;
  return *options.frame / options.fps.value_or(kDefaultFps);
}

}  // namespace skywave
