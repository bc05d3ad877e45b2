// Gradient noise in space, for textures that are computed.
#pragma once

#include <glm/glm.hpp>

namespace skywave {

// Returns noise between -1 and 1 that is 0 at whole coordinates (Perlin 2002, "Improving Noise",
// with its permutation). Coordinates repeat after 256.
double GradientNoise(const glm::dvec3& at);

// Returns the sum of `octaves` noises, each 1.99 times as fine as the one before and `roughness`
// times as strong. The factor is not 2, so that their zeros do not coincide.
double FractalNoise(glm::dvec3 at, double roughness, int octaves);

// Returns the sum of the magnitudes of such noises, and 0.2 times the strength of one more, as pbrt
// has it.
double TurbulentNoise(glm::dvec3 at, double roughness, int octaves);

// Returns whether (s, t) is in a dot: about half of the cells around whole numbers have one, of
// radius 0.35, somewhere within the cell (pbrt).
bool IsInDot(const glm::dvec2& at);

}  // namespace skywave
