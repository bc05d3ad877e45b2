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

// Returns a metal by its chemical symbol, Ag, Al, Au, Cu, CuZn, MgO or TiO2, and
// nothing for others.
std::optional<MetalIndex> FindMetal(std::string_view symbol);

// Returns the metal with eta = 1 that has this reflectance at normal incidence, as pbrt-v4 does.
// Channels are cut at 0.9999.
MetalIndex MetalOfReflectance(const glm::vec3& reflectance);

}  // namespace skywave
