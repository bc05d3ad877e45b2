// The baselines that every other strategy is measured against.
//
// uniform  directions uniform over the sphere, density 1 / 4 pi, whatever the map.
// cosine   directions about the shading normal, density cos / pi (P 3-6), whatever the map.
// Neither has parameters.
#pragma once

#include "lights/strategy.h"
#include "lights/texels.h"

namespace skywave {

class UniformStrategy final : public EnvStrategy {
 public:
  explicit UniformStrategy(const EnvironmentMap& map) : texels_(map) {}
  std::string_view name() const override { return "uniform"; }
  std::size_t table_bytes() const override { return texels_.bytes(); }
  void Sample(const SurfaceColumns& surfaces, const UniformColumns& uniforms, std::uint32_t n,
              const LightColumns& out) const override;
  void EvaluateEscaped(const SurfaceColumns& surfaces, std::uint32_t n,
                       const EscapeColumns& rows) const override;

 private:
  Texels texels_;
};

class CosineStrategy final : public EnvStrategy {
 public:
  explicit CosineStrategy(const EnvironmentMap& map) : texels_(map) {}
  std::string_view name() const override { return "cosine"; }
  std::size_t table_bytes() const override { return texels_.bytes(); }
  void Sample(const SurfaceColumns& surfaces, const UniformColumns& uniforms, std::uint32_t n,
              const LightColumns& out) const override;
  void EvaluateEscaped(const SurfaceColumns& surfaces, std::uint32_t n,
                       const EscapeColumns& rows) const override;

 private:
  Texels texels_;
};

}  // namespace skywave
