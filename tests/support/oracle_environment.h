// The illumination map of the oracle: look-ups and light samples in double, from the float picture.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scene/scene.h"
#include "tests/support/oracle_random.h"

namespace skywave {

// The distribution of light samples.
enum class OracleLights { kImportance, kUniform };

class OracleEnvironment {
 public:
  // `light` is constant, or a lat-long map in memory.
  OracleEnvironment(const EnvironmentLight& light, OracleLights lights);

  // Returns the radiance that the eye sees, directly or via mirrors and glass: interpolated between
  // texel centres.
  glm::dvec3 Seen(const glm::dvec3& direction) const;
  // The map as a light, constant inside a texel, and the density of Sample [1/sr].
  struct Lit {
    glm::dvec3 radiance;
    double pdf;
  };
  Lit AsLight(const glm::dvec3& direction) const;

  struct LightSample {
    glm::dvec3 direction, radiance;
    double pdf;
  };
  LightSample Sample(OracleRandom& random) const;

 private:
  glm::dvec3 Texel(int column, int row) const;
  void Position(const glm::dvec3& direction, double& u, double& v) const;
  double Density(int column, int row) const;

  int width_, height_;
  std::vector<float> rgb_;
  glm::dvec3 scale_;
  glm::dmat3 world_from_map_;
  OracleLights lights_;
  std::vector<double> solid_angle_;        // solid angle of a texel in each row [sr]
  std::vector<double> cumulative_rows_;    // height + 1, from 0 to 1
  std::vector<double> cumulative_texels_;  // width + 1 per row, from 0 to 1
};

}  // namespace skywave
