#include "lights/strategy_baselines.h"

#include <algorithm>
#include <numbers>

namespace skywave {

void UniformStrategy::Sample(const SurfaceColumns&, const UniformColumns& uniforms, std::uint32_t n,
                             const LightColumns& out) const {
  SampleSphere(uniforms, n, out);
  LookUpTexels(texels_.view(), n, out);
}

void UniformStrategy::EvaluateEscaped(const SurfaceColumns&, std::uint32_t n,
                                      const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), nullptr, n, rows);
  std::fill_n(rows.light_pdf, n, float(0.25 / std::numbers::pi));
}

void CosineStrategy::Sample(const SurfaceColumns& surfaces, const UniformColumns& uniforms,
                            std::uint32_t n, const LightColumns& out) const {
  SampleCosine(surfaces, uniforms, n, out);
  LookUpTexels(texels_.view(), n, out);
}

void CosineStrategy::EvaluateEscaped(const SurfaceColumns& surfaces, std::uint32_t n,
                                     const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), nullptr, n, rows);
  CosineDensity(surfaces, n, rows);
}

}  // namespace skywave
