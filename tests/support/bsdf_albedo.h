// The directional albedo of a BSDF as its kernels scatter.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/bsdf_cases.h"
#include "tests/support/shading_rows.h"

namespace skywave {

// Computes the directional albedo as the mean weight over a Kronecker sequence (error about 1e-4).
inline std::array<double, 3> Albedo(const MaterialCase& material, double cosine) {
  constexpr std::uint32_t kSamples = 20000;
  const Vec normal = {0, 0, 1};
  const ShadingRows rows(material, kSamples, normal, AtAngle(normal, cosine));
  const ScatterRows uniforms(kSamples);
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    // The steps are inverse powers of the root of x^4 = x + 1, the generalised golden ratio for
    // three dimensions.
    const auto point = [&](double step) {
      const double x = 0.5 + i * step;
      return float(std::min(x - std::floor(x), 1 - 0x1p-24));
    };
    uniforms.direction->u[i] = point(0.8191725133961645);
    uniforms.direction->v[i] = point(0.6710436067037893);
    uniforms.lobe->u[i] = point(0.5497004779019703);
  }
  soa::Table<RayColumns> rays(kSamples);
  const std::uint32_t alive =
      rows.kernels.scatter(rows.surfaces, rows.materials(), uniforms.view(), kSamples, {}, rays, 0);
  std::array<double, 3> sum = {};
  const double ratio = TransmissionRatio(material).value_or(1);
  for (std::uint32_t i = 0; i < alive; ++i) {
    // Energy, unlike radiance, has no factor of the squared index ratio.
    const double scale = rays->dir_z[i] < 0 ? 1 / (ratio * ratio) : 1;
    sum[0] += scale * rays->throughput_r[i], sum[1] += scale * rays->throughput_g[i];
    sum[2] += scale * rays->throughput_b[i];
  }
  for (double& value : sum) value /= kSamples;
  return sum;
}

}  // namespace skywave
