// The local lights of the oracle, in double. All are selected equally often, whatever their power.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "scene/scene.h"
#include "tests/support/oracle_random.h"

namespace skywave {

// Returns what a point, a spot or a shaped light sends into a direction of the world (any length),
// over its emission.
glm::dvec3 OracleLightFactor(const PunctualLight& light, const std::vector<CompactImage>& images,
                             const glm::dvec3& direction);

class OracleLocalLights {
 public:
  struct Triangle {
    glm::dvec3 corner[3];
    glm::dvec3 radiance;
    bool two_sided;
    std::uint32_t index = 0;  // the oracle's index
  };

  OracleLocalLights() = default;
  OracleLocalLights(std::vector<Triangle> triangles, std::vector<PunctualLight> lights,
                    std::vector<CompactImage> images)
      : triangles_(std::move(triangles)), lights_(std::move(lights)), images_(std::move(images)) {}
  bool empty() const { return triangles_.empty() && lights_.empty(); }

  // A light seen from `point`. A light without extent has pdf 0, and its radiance is its
  // contribution to a surface that faces it, divided by the probability of selecting it.
  struct LightSample {
    glm::dvec3 direction, radiance;
    double pdf;  // [1/sr]
    double distance;
    std::optional<std::uint32_t> triangle = {};  // the triangle; u, v: the point on it
    double u = 0, v = 0;
  };
  // Returns nothing if the light faces away.
  std::optional<LightSample> Sample(const glm::dvec3& point, OracleRandom& random) const;

  // Returns the density of Sample for a direction that hits a triangle at `distance` with that
  // cosine.
  double Pdf(const Triangle& triangle, double distance, double cosine) const;

 private:
  std::vector<Triangle> triangles_;
  std::vector<PunctualLight> lights_;
  std::vector<CompactImage> images_;
};

}  // namespace skywave
