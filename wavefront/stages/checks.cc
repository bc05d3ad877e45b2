#include "wavefront/stages/checks.h"

#ifdef SKYWAVE_CHECKS

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace skywave {
namespace {

void Require(bool holds, const char* what, std::uint32_t row, float a, float b, float c) {
  if (holds) return;
  std::fprintf(stderr, "invariant broken: %s, row %u: %g %g %g\n", what, row, double(a), double(b),
               double(c));
  std::abort();
}

bool IsUnit(float x, float y, float z) { return std::fabs(x * x + y * y + z * z - 1) < 1e-4f; }
bool IsRadiance(float r, float g, float b) {
  return std::isfinite(r) && std::isfinite(g) && std::isfinite(b) && r >= 0 && g >= 0 && b >= 0;
}

}  // namespace

void CheckRays(const RayColumns& s, std::uint32_t n) {
  for (std::uint32_t i = 0; i < n; ++i) {
    Require(std::isfinite(s.org_x[i]) && std::isfinite(s.org_y[i]) && std::isfinite(s.org_z[i]),
            "ray origin is finite", i, s.org_x[i], s.org_y[i], s.org_z[i]);
    Require(IsUnit(s.dir_x[i], s.dir_y[i], s.dir_z[i]), "ray direction is a unit vector", i,
            s.dir_x[i], s.dir_y[i], s.dir_z[i]);
    Require(IsRadiance(s.throughput_r[i], s.throughput_g[i], s.throughput_b[i]),
            "throughput is finite and >= 0", i, s.throughput_r[i], s.throughput_g[i],
            s.throughput_b[i]);
    Require(s.pdf[i] >= 0, "ray density is >= 0", i, s.pdf[i], 0, 0);
  }
}

void CheckSurfaces(const SurfaceColumns& s, std::uint32_t n) {
  for (std::uint32_t i = 0; i < n; ++i) {
    Require(IsUnit(s.ng_x[i], s.ng_y[i], s.ng_z[i]), "geometric normal is a unit vector", i,
            s.ng_x[i], s.ng_y[i], s.ng_z[i]);
    Require(IsUnit(s.ns_x[i], s.ns_y[i], s.ns_z[i]), "shading normal is a unit vector", i,
            s.ns_x[i], s.ns_y[i], s.ns_z[i]);
    const float side = s.ns_x[i] * s.wo_x[i] + s.ns_y[i] * s.wo_y[i] + s.ns_z[i] * s.wo_z[i];
    Require(side >= 0, "shading normal is on the side of the eye", i, side, 0, 0);
  }
}

void CheckLightSamples(const LightColumns& s, std::uint32_t n) {
  for (std::uint32_t i = 0; i < n; ++i) {
    Require(IsUnit(s.dir_x[i], s.dir_y[i], s.dir_z[i]), "light direction is a unit vector", i,
            s.dir_x[i], s.dir_y[i], s.dir_z[i]);
    Require(IsRadiance(s.r[i], s.g[i], s.b[i]), "light radiance is finite and >= 0", i, s.r[i],
            s.g[i], s.b[i]);
    Require(!std::isnan(s.pdf[i]), "light density is a number", i, s.pdf[i], 0, 0);
  }
}

void CheckShadowRays(const LightColumns& s, std::uint32_t n) {
  for (std::uint32_t i = 0; i < n; ++i) {
    Require(!std::isnan(s.t_far[i]), "reach of a shadow ray is a number", i, s.t_far[i], 0, 0);
    Require(s.t_far[i] < 0 || IsUnit(s.dir_x[i], s.dir_y[i], s.dir_z[i]),
            "direction of a shadow ray is a unit vector", i, s.dir_x[i], s.dir_y[i], s.dir_z[i]);
  }
}

}  // namespace skywave

#endif  // SKYWAVE_CHECKS
