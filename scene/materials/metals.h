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

// The metal with eta = 1 that reflects so much at normal incidence, as pbrt-v4 has it. Beyond
// 0.9999 of a channel it takes that.
MetalIndex MetalOfReflectance(const glm::vec3& reflectance);

}  // namespace skywave
