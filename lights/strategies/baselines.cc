#include "lights/strategies/baselines.h"

#include <algorithm>
#include <numbers>

namespace skywave {

void UniformStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                             LightCall call, const LightColumns& out) const {
  SampleSphere(uniforms, n, call.samples(), out);
  LookUpTexels(texels_.view(), n, out);
}

void UniformStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float samples,
                                      const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), {}, n, 0, rows);
  std::fill_n(rows.light_pdf, n, float(0.25 / std::numbers::pi) * samples);
}

void CosineStrategy::Sample(const ShadePoints& points, const UniformColumns& uniforms,
                            std::uint32_t n, LightCall call, const LightColumns& out) const {
  SampleCosine(points.surfaces, uniforms, n, call.samples(), out);
  LookUpTexels(texels_.view(), n, out);
}

void CosineStrategy::EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                                     const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), {}, n, 0, rows);
  CosineDensity(points.surfaces, n, samples, rows);
}

void BsdfStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float,
                                   const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), {}, n, 0, rows);
}

StrategyFactory UniformFactory() {
  return {"uniform",
          "uniform over the sphere (baseline)",
          {},
          [](const EnvironmentMap& map, const StrategyValues&) -> std::unique_ptr<EnvStrategy> {
            return std::make_unique<UniformStrategy>(map);
          }};
}

StrategyFactory CosineFactory() {
  return {"cosine",
          "cosine about the shading normal (baseline)",
          {},
          [](const EnvironmentMap& map, const StrategyValues&) -> std::unique_ptr<EnvStrategy> {
            return std::make_unique<CosineStrategy>(map);
          }};
}

StrategyFactory BsdfFactory() {
  return {"bsdf",
          "BSDF sampling alone (baseline)",
          {},
          [](const EnvironmentMap& map, const StrategyValues&) -> std::unique_ptr<EnvStrategy> {
            return std::make_unique<BsdfStrategy>(map);
          }};
}

}  // namespace skywave
