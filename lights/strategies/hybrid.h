// hybrid: the thesis's scheme (T 7.4). The map is divided into A, bright and small, and B, the
// rest; A becomes directional lights, B is drawn at random; both are summed, so nothing is counted
// twice.
//
// Parameters
//   strata=variation  where A ends: variation (T 7.17-7.21), p (fraction of the energy), or lights
//                     (room for `lights` of them, `angle` degrees apart, T 7.15)
//   p=0.5, angle=10   for these
//   lights=64, from=penrose, position=, longest=, lloyd=, cluster=, clusters=, separation=: A's
//                     lights; the bias of lights=auto:BIAS is relative to the whole map's light
//   file=             a file of A's lights (skywave probe presample --strata); A is where they have
//                     cells, and the parameters above are not used
//   pick=all          all of A's lights at every hit, then the light samples from B (the thesis's
//                     direct lighting), or power: each light sample from A's lights or from B, by
//                     their energy (its PT1)
//   rest=importance   B by inversion; presampled: cells of B, picked by energy (MPA, T 7.3), with
//   rest-samples=360  cells,
//   rest-from=same    placed as A's lights, or by another source: the thesis has median cut in A
//                     and Penrose in B,
//   rest-mode=fixed   the light of a cell, or jittered: a texel in it;
//                     or product: B times the BSDF (T 8.4), from
//   rest-cells=96     cells (lights/strategies/product.h); not with inside=1
//   inside=0          1: instead of the light of each of A's cells one sample inside the cell, by
//                     importance: stratified, with a density. Unbiased unless B is fixed lights.
//                     Needs pick=all.
#pragma once

#include <optional>

#include "lights/light_sets/directional_lights.h"
#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/strata.h"
#include "lights/strategies/product.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/cell_sampler.h"
#include "lights/tables/inversion_table.h"
#include "lights/tables/texels.h"

namespace skywave {

// How the stratum B is drawn.
enum class HybridRest { kImportance, kLights, kCells, kProduct };

struct HybridOptions {
  StrataRequest strata;
  LightOptions lights;
  std::string file;  // of A's lights; empty: strata and lights make them
  bool all = true;
  HybridRest rest = HybridRest::kImportance;
  LightSource rest_source = LightSource::kPenrose;  // of kLights and kCells
  int rest_samples = 360;                           // likewise
  int rest_cells = kDefaultProductCells;            // of kProduct
  bool inside = false;
};

class HybridStrategy final : public EnvStrategy {
 public:
  HybridStrategy(const EnvironmentMap& map, const HybridOptions& options);

  std::string_view name() const override { return "hybrid"; }
  std::size_t table_bytes() const override;
  std::string note() const override { return note_; }
  bool depends_on_surface() const override { return rest_product_.has_value(); }
  bool shines_on_bsdf_samples() const override { return !rest_lights_ || cells_; }
  bool unbiased() const override { return options_.inside && !rest_lights_; }
  LightPlan Plan(std::uint32_t requested) const override;
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  LightSet MakeLightsOfA(const SphereMap& map, Image& a, Image& b);
  void MakeRest(const EnvironmentMap& map, const Image& b);
  void SampleRest(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
                  LightCall call, const LightColumns& out) const;

  HybridOptions options_;
  std::string note_;
  float share_ = 0;                          // of A in the energy
  bool rest_is_dark_ = false;                // B has nothing to draw
  std::optional<Texels> texels_;             // what escaped rays see as a light
  std::optional<DirectionalLights> lights_;  // of A
  std::optional<CellSampler> cells_;         // of A, where inside
  std::vector<float> cell_density_;          // of A's samples, where inside [1/sr]
  std::optional<Texels> rest_texels_;        // B, where texels_ hold A too
  // One of them draws from B.
  std::optional<InversionTable> rest_table_;
  std::optional<DirectionalLights> rest_lights_;
  std::optional<CellSampler> rest_cells_;
  std::optional<ProductStrategy> rest_product_;
};

std::span<const StrategyParameter> HybridParameters();
HybridOptions ReadHybridOptions(const StrategyValues& values);

}  // namespace skywave
