#include "lights/strategy_baselines.h"

#include <algorithm>
#include <numbers>

namespace skywave {

void UniformStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                             LightCall call, const LightColumns& out) const {
  SampleSphere(uniforms, n, float(call.requested), out);
  LookUpTexels(texels_.view(), n, out);
}

void UniformStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, std::uint32_t requested,
                                      const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), {}, n, 0, rows);
  std::fill_n(rows.light_pdf, n, float(0.25 / std::numbers::pi) * float(requested));
}

void CosineStrategy::Sample(const ShadePoints& points, const UniformColumns& uniforms,
                            std::uint32_t n, LightCall call, const LightColumns& out) const {
  SampleCosine(points.surfaces, uniforms, n, float(call.requested), out);
  LookUpTexels(texels_.view(), n, out);
}

void CosineStrategy::EvaluateEscaped(const ShadePoints& points, std::uint32_t n,
                                     std::uint32_t requested, const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), {}, n, 0, rows);
  CosineDensity(points.surfaces, n, float(requested), rows);
}

void BsdfStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, std::uint32_t,
                                   const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), {}, n, 0, rows);
}

}  // namespace skywave
