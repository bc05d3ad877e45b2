#include "tests/support/facet_quadrature.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

namespace skywave {

double KeptByFacets(double x, double y, const glm::dvec3& wo, std::optional<double> ratio,
                    int radii, int turns) {
  using glm::dvec3;
  const auto lambda = [&](const dvec3& w) {
    const double slope2 = (std::pow(x * w.x, 2) + std::pow(y * w.y, 2)) / (w.z * w.z);
    return 0.5 * (std::sqrt(1 + slope2) - 1);
  };
  const double lambda_o = lambda(wo);
  double sum = 0;
  for (int i = 0; i < radii; ++i) {
    // Steep facets are few and are seen large: places are dense where u is near 1.
    const double v = 1 - (i + 0.5) / radii, u = 1 - v * v, radius = std::sqrt(u / (1 - u));
    for (int j = 0; j < turns; ++j) {
      const double phi = 2 * std::numbers::pi * (j + 0.5) / turns;
      const dvec3 h =
          glm::normalize(dvec3(x * radius * std::cos(phi), y * radius * std::sin(phi), 1));
      const double facing = std::min(glm::dot(wo, h), 1.0);
      if (facing <= 0) continue;
      const double seen = 2 * v * facing / (wo.z * h.z);
      const dvec3 reflected = 2 * facing * h - wo;
      const double sine2 = ratio ? *ratio * *ratio * (1 - facing * facing) : 1;
      const double inside = std::sqrt(std::max(0.0, 1 - sine2));
      double reflectance = 1;
      if (sine2 < 1) {
        const double across = (*ratio * facing - inside) / (*ratio * facing + inside);
        const double along = (facing - *ratio * inside) / (facing + *ratio * inside);
        reflectance = 0.5 * (across * across + along * along);
      }
      if (reflected.z > 0) sum += reflectance * seen / (1 + lambda_o + lambda(reflected));
      if (reflectance == 1) continue;
      const dvec3 refracted = (*ratio * facing - inside) * h - *ratio * wo;
      if (refracted.z < 0) sum += (1 - reflectance) * seen / (1 + lambda_o + lambda(refracted));
    }
  }
  return sum / (double(radii) * turns);
}

}  // namespace skywave
