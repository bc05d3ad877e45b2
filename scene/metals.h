// Complex indices of refraction of common metals, as three channels.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string_view>

namespace skywave {

struct MetalIndex {
  glm::vec3 eta;  // real part, red, green, blue
  glm::vec3 k;    // imaginary part
};

// By chemical symbol: Ag, Al, Au, Cu. Nothing for others.
std::optional<MetalIndex> FindMetal(std::string_view symbol);

}  // namespace skywave
