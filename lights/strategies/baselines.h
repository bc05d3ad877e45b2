// The baselines that every other strategy is measured against.
//
// uniform  directions uniform over the sphere, density 1 / 4 pi, whatever the map.
// cosine   directions about the shading normal, density cos / pi (P 3-6), whatever the map.
// bsdf     no light samples: light is found by BSDF sampling alone. GuideSamples it, so not with
// --no-mis. None has parameters.
#pragma once

#include "lights/strategies/strategy.h"
#include "lights/tables/texels.h"

namespace skywave {

class UniformStrategy final : public EnvStrategy {
 public:
  explicit UniformStrategy(const EnvironmentMap& map) : texels_(map) {}
  std::string_view name() const override { return "uniform"; }
  std::size_t table_bytes() const override { return texels_.bytes(); }
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  Texels texels_;
};

class CosineStrategy final : public EnvStrategy {
 public:
  explicit CosineStrategy(const EnvironmentMap& map) : texels_(map) {}
  std::string_view name() const override { return "cosine"; }
  bool depends_on_surface() const override { return true; }
  std::size_t table_bytes() const override { return texels_.bytes(); }
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  Texels texels_;
};

class BsdfStrategy final : public EnvStrategy {
 public:
  explicit BsdfStrategy(const EnvironmentMap& map) : texels_(map) {}
  std::string_view name() const override { return "bsdf"; }
  std::size_t table_bytes() const override { return texels_.bytes(); }
  LightPlan Plan(std::uint32_t) const override { return {.drawn = 0}; }
  bool complete() const override { return false; }
  void Sample(const ShadePoints&, const UniformColumns&, std::uint32_t, LightCall,
              const LightColumns&) const override {}
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  Texels texels_;
};

}  // namespace skywave
