// What GGX facets keep of the light by scattering it once, by a quadrature that does not use
// visible normals, as the tables of the engine do.
#pragma once

#include <glm/vec3.hpp>
#include <optional>

namespace skywave {

// Returns the share of light from wo, in the tangent frame, that facets of widths x and y keep:
// those of a metal with F = 1, or of glass where `ratio` (near index over far index) is given. It
// takes `radii` times `turns` half vectors, distributed as D(h) cos.
double KeptByFacets(double x, double y, const glm::dvec3& wo, std::optional<double> ratio,
                    int radii, int turns);

}  // namespace skywave
