// hybrid: the thesis's scheme (T 7.4). The map is divided into A, bright and small, and B, the
// rest; A becomes directional lights, B is drawn at random; both are summed, so nothing is counted
// twice.
//
// Parameters
//   strata=variation  where A ends: variation (T 7.17-7.21), p (fraction of the energy), or lights
//                     (room for `lights` of them, `angle` degrees apart, T 7.15)
//   p=0.5, angle=10   for these
//   lights=64, from=penrose, position=, lloyd=, cluster=, clusters=, separation=: A's lights;
//                     the bias of lights=auto:BIAS is relative to the whole map's light
//   pick=all          all of A's lights at every hit, then the light samples from B (the thesis's
//                     direct lighting), or power: each light sample from A's lights or from B, by
//                     their energy (its PT1)
//   rest=importance   B by inversion, or presampled: the lights of
//   rest-samples=360  cells of B, picked by energy (MPA, T 7.3)
//   inside=0          1: instead of the light of each of A's cells one sample inside the cell, by
//                     importance: stratified, with a density. Unbiased with rest=importance.
//                     GuideSamples pick=all.
#pragma once

#include <optional>

#include "lights/light_sets/directional_lights.h"
#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/strata.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/cell_sampler.h"
#include "lights/tables/inversion_table.h"
#include "lights/tables/texels.h"

namespace skywave {

struct HybridOptions {
  StrataRequest strata;
  LightOptions lights;
  bool all = true;
  bool presampled = false;
  int rest_samples = 360;
  bool inside = false;
};

class HybridStrategy final : public EnvStrategy {
 public:
  HybridStrategy(const EnvironmentMap& map, const HybridOptions& options);

  std::string_view name() const override { return "hybrid"; }
  std::size_t table_bytes() const override;
  std::string note() const override { return note_; }
  bool shines_on_bsdf_samples() const override { return rest_table_ || cells_; }
  bool unbiased() const override { return options_.inside && !options_.presampled; }
  LightPlan Plan(std::uint32_t requested) const override;
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  bool RestIsDark() const;
  void SampleRest(const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out) const;

  HybridOptions options_;
  std::string note_;
  float share_ = 0;                               // of A in the energy
  std::optional<Texels> texels_;                  // what escaped rays see as a light
  std::optional<DirectionalLights> lights_;       // of A
  std::optional<CellSampler> cells_;              // of A, where inside
  std::vector<float> cell_density_;               // of A's samples, where inside [1/sr]
  std::optional<Texels> rest_texels_;             // B, where texels_ hold A too
  std::optional<InversionTable> rest_table_;      // of B
  std::optional<DirectionalLights> rest_lights_;  // of B, where presampled
};

std::span<const StrategyParameter> HybridParameters();
HybridOptions ReadHybridOptions(const StrategyValues& values);

}  // namespace skywave
