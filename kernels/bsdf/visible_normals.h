// The visible normals of GGX facets (Heitz 2018) on a grid, and how a dielectric facet splits
// light, in double: for tables that are computed once.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {

// A unit vector in the frame of a surface.
struct Facing {
  double x, y, z;
};
// Returns the direction at cosine `mu` whose |y| / (|x| + |y|) is `y_share`.
inline Facing FacingAt(double mu, double y_share) {
  const double sine = std::sqrt(1 - mu * mu), norm = std::hypot(1 - y_share, y_share);
  return {sine * (1 - y_share) / norm, sine * y_share / norm, mu};
}

// `ratio` is the index on the light's side over that on the other one.
struct Split {
  double reflectance, cosine;  // that of the refracted ray
};
inline Split FresnelSplit(double cosine, double ratio) {
  const double sine2 = ratio * ratio * (1 - cosine * cosine);
  if (sine2 >= 1) return {1, 0};
  const double inner = std::sqrt(1 - sine2);
  const double p = (cosine - ratio * inner) / (cosine + ratio * inner);
  const double s = (ratio * cosine - inner) / (ratio * cosine + inner);
  return {0.5 * (p * p + s * s), inner};
}

// Returns Smith's Lambda of GGX facets of that width (Heitz 2014, eq. 72).
inline double GgxLambda(double alpha, double cosine) {
  const double tan2 = (1 - cosine * cosine) / (cosine * cosine);
  return 0.5 * (std::sqrt(1 + alpha * alpha * tan2) - 1);
}

// Returns that of facets of two widths, along x and across it.
inline double GgxLambda(double x_width, double y_width, const Facing& w) {
  const double along = x_width * w.x, across = y_width * w.y;
  return 0.5 * (std::sqrt(1 + (along * along + across * across) / (w.z * w.z)) - 1);
}

// A facet as seen from a direction: the z of its normal, its cosine to that direction, and the
// whole normal.
struct VisibleFacet {
  double z, toward;
  Facing normal;
};

// Calls f(facet) for turns x heights visible normals of equal probability, as seen from `wo`, in
// the spherical-cap parametrisation of Dupuy and Benyoub 2023. `stretched` is the unit vector of wo
// with its x and y times the widths; turns go through the angle `span`. Heights are the middles of
// equal parts, which `shift` shifts from turn to turn.
template <class F>
void ForEachVisibleFacet(double x_width, double y_width, const Facing& wo, const Facing& stretched,
                         double span, double shift, int turns, int heights, const F& f) {
  for (int turn = 0; turn < turns; ++turn) {
    const double shifted = 0.5 + turn * shift, place = shifted - std::floor(shifted);
    const double phi = span * (turn + 0.5) / turns, cosine = std::cos(phi), sine = std::sin(phi);
    for (int height = 0; height < heights; ++height) {
      const double cap = 1 - (height + place) / heights * (1 + stretched.z);
      const double radius = std::sqrt(std::max(0.0, 1 - cap * cap));
      double hx = (radius * cosine + stretched.x) * x_width;
      double hy = (radius * sine + stretched.y) * y_width;
      double hz = std::max(0.0, cap + stretched.z);
      const double length = std::sqrt(hx * hx + hy * hy + hz * hz);
      if (length == 0) continue;
      hx /= length, hy /= length, hz /= length;
      f(VisibleFacet{hz, hx * wo.x + hy * wo.y + hz * wo.z, {hx, hy, hz}});
    }
  }
}

// The same over all turns, by a lattice, because the result may jump from one facet to the next.
template <class F>
void ForEachVisibleFacet(double x_width, double y_width, const Facing& wo, int turns, int heights,
                         const F& f) {
  const double x = x_width * wo.x, y = y_width * wo.y, length = std::hypot(x, y, wo.z);
  ForEachVisibleFacet(x_width, y_width, wo, {x / length, y / length, wo.z / length},
                      2 * std::numbers::pi, 1 / std::numbers::phi, turns, heights, f);
}

// The same for facets of one width, as seen from a direction in the plane y = 0 at cosine `mu`.
template <class F>
void ForEachVisibleFacet(double alpha, double mu, int turns, int heights, const F& f) {
  const double sine = std::sqrt(1 - mu * mu);
  double x = alpha * sine, z = mu;
  const double norm = std::hypot(x, z);
  x /= norm, z /= norm;
  // The other half of the turns mirrors this one.
  ForEachVisibleFacet(alpha, alpha, {sine, 0, mu}, {x, 0, z}, std::numbers::pi, 0, turns, heights,
                      f);
}

}  // namespace skywave
