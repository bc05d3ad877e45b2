// ris: resampled importance sampling (Talbot, Cline and Egbert 2005). Every light sample is chosen
// among candidates drawn from the map (importance) and from the BSDF, in proportion to what they
// would contribute if nothing were in between: one shadow ray for many evaluations. Pays off where
// rays cost more than evaluations.
//
// Parameters
//   map=4    candidates from the map
//   bsdf=1   candidates from the BSDF; 0 is right for maps without much light that lobes alone find
//
// Unbiased. The candidates include BSDF samples, and the chosen direction has no density in closed
// form, so rays that scatter see no light (as with directional lights), and --no-mis has no effect.
#pragma once

#include "kernels/bsdf/resampling.h"
#include "lights/strategies/importance.h"

namespace skywave {

class RisStrategy final : public EnvStrategy {
 public:
  RisStrategy(const EnvironmentMap& map, CandidateCounts counts)
      : map_(map, /*compensate=*/0), counts_(counts) {}

  std::string_view name() const override { return "ris"; }
  bool depends_on_surface() const override { return true; }
  std::size_t table_bytes() const override { return map_.table_bytes(); }
  bool shines_on_bsdf_samples() const override { return false; }
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  ImportanceStrategy map_;
  CandidateCounts counts_;
};

}  // namespace skywave
