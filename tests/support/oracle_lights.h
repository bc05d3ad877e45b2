// The local lights of the oracle, in double: each is picked as often as any other, whatever its
// power.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "scene/scene.h"
#include "tests/support/oracle_random.h"

namespace skywave {

class OracleLocalLights {
 public:
  struct Triangle {
    glm::dvec3 corner[3];
    glm::dvec3 radiance;
    bool two_sided;
    std::uint32_t index = 0;  // the oracle's
  };

  OracleLocalLights() = default;
  OracleLocalLights(std::vector<Triangle> triangles, std::vector<PunctualLight> lights)
      : triangles_(std::move(triangles)), lights_(std::move(lights)) {}
  bool empty() const { return triangles_.empty() && lights_.empty(); }

  // A light seen from `point`. pdf of a light without extent is 0, and its radiance what it brings
  // a surface that faces it, divided by its probability.
  struct LightSample {
    glm::dvec3 direction, radiance;
    double pdf;  // [1/sr]
    double distance;
    std::optional<std::uint32_t> triangle = {};  // where on which one
    double u = 0, v = 0;
  };
  // Nothing where the light looks away.
  std::optional<LightSample> Sample(const glm::dvec3& point, OracleRandom& random) const;

  // Density of Sample for a direction that meets a triangle `distance` away with that cosine.
  double Pdf(const Triangle& triangle, double distance, double cosine) const;

 private:
  std::vector<Triangle> triangles_;
  std::vector<PunctualLight> lights_;
};

}  // namespace skywave
