// The visible normals of GGX facets (Heitz 2018) on a grid, in double: for tables that are computed
// once.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {

// Returns Smith's Lambda of GGX facets of that width (Heitz 2014, eq. 72).
inline double GgxLambda(double alpha, double cosine) {
  const double tan2 = (1 - cosine * cosine) / (cosine * cosine);
  return 0.5 * (std::sqrt(1 + alpha * alpha * tan2) - 1);
}

// A facet as seen from a direction in the plane y = 0: its normal's z, and its cosine to that
// direction.
struct VisibleFacet {
  double z, toward;
};

// Calls f(facet) for turns x heights visible normals of equal probability, as seen at cosine `mu`,
// by the midpoint rule in the spherical-cap parametrisation of Dupuy and Benyoub 2023.
template <class F>
void ForEachVisibleFacet(double alpha, double mu, int turns, int heights, const F& f) {
  const double sine = std::sqrt(1 - mu * mu);
  double x = alpha * sine, z = mu;
  const double norm = std::hypot(x, z);
  x /= norm, z /= norm;
  for (int turn = 0; turn < turns; ++turn) {
    const double phi = std::numbers::pi * (turn + 0.5) / turns;  // the other half mirrors it
    for (int height = 0; height < heights; ++height) {
      const double cap = 1 - (height + 0.5) / heights * (1 + z);
      const double radius = std::sqrt(std::max(0.0, 1 - cap * cap));
      double hx = (radius * std::cos(phi) + x) * alpha, hy = radius * std::sin(phi) * alpha;
      double hz = std::max(0.0, cap + z);
      const double length = std::sqrt(hx * hx + hy * hy + hz * hz);
      if (length == 0) continue;
      hx /= length, hz /= length;
      f(VisibleFacet{hz, hx * sine + hz * mu});
    }
  }
}

}  // namespace skywave
