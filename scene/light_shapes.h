// Shapes of a scene's lights as the kernels read them (kernels/lights/light_shapes.h).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "kernels/lights/light_shapes.h"
#include "scene/scene.h"

namespace skywave {

// Returns the direction, unit, of a point of the square of LightMapping::kSphere.
glm::dvec3 DirectionOfSquare(double s, double t);

struct LightShapeTables {
  std::vector<LightShape> shapes;
  std::vector<float> texels;
  std::vector<std::uint32_t> choices;

  LightShapeView view() const;  // valid as long as the tables stay where they are
  std::size_t bytes() const;
};

// Adds the shape of a light that has one. Returns the integral of its factors over all directions
// of the world [sr], summed over points of every texel. Throws InputError(path) for more texels
// than a table can hold.
glm::dvec3 AddLightShape(const Scene& scene, const PunctualLight& light, const std::string& path,
                         LightShapeTables& tables);

// Returns bounds as those of LightChoice: `units` are distributed in proportion to the weights, at
// least one to each that is not 0.
std::vector<std::uint32_t> MakeChoice(const std::vector<double>& weights, std::uint32_t units);

}  // namespace skywave
