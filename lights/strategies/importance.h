// importance: directions drawn with a density proportional to the luminance of the map, by
// inversion of its two-dimensional distribution: a row by the marginal, a column by the row's own
// distribution (T 6.1; Pharr and Humphreys 2004). Monotone in both uniforms, so well-distributed
// points stay so.
//
// Parameters
//   compensate=1/n  share of the mean luminance that is subtracted from the density, 0 to 1 (Karlik
//                   et al. 2019, "MIS Compensation"): light samples go where BSDF samples would not
//                   find the light. 1 suits one light sample a hit, 1 / n suits n of them; more
//                   makes noise, for the one BSDF sample is alone with the rest. That is the
//                   default with multiple importance sampling. Dark directions are then never
//                   drawn, so it needs BSDF sampling beside it: the default is 0 with --no-mis, and
//                   where light paths start with its samples.
//
// Densities are exact: whatever rounding the tables have, the density that is reported is the one
// that is drawn (but for texels 2^-24 as bright as a neighbour: PickTexels). A black map is sampled
// uniformly over the sphere.
#pragma once

#include <optional>

#include "lights/strategies/strategy.h"
#include "lights/tables/inversion_table.h"
#include "lights/tables/oriented_tables.h"
#include "lights/tables/texels.h"

namespace skywave {

class ImportanceStrategy final : public EnvStrategy {
 public:
  ImportanceStrategy(const EnvironmentMap& map, double compensate);
  // By another importance of every texel than its luminance: >= 0, not all 0, and not 0 where there
  // is light.
  ImportanceStrategy(const EnvironmentMap& map, const std::vector<double>& importance);

  std::string_view name() const override { return "importance"; }
  std::size_t table_bytes() const override;
  std::unique_ptr<EnvStrategy> Turned(const EnvironmentMap& map) const override;
  bool complete() const override { return tables_->compensated == 0; }
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  struct Tables {
    Tables(const EnvironmentMap& map, double compensate);
    Tables(const EnvironmentMap& map, const std::vector<double>& importance);
    Texels texels;
    std::optional<Texels> weights;  // what is drawn by in place of `texels`
    double compensated;             // share of the mean
    InversionTable inversion;       // points at them
  };
  explicit ImportanceStrategy(OrientedTables<Tables> tables) : tables_(std::move(tables)) {}

  OrientedTables<Tables> tables_;
};

// Returns the default of the parameter `compensate`.
std::string DefaultCompensation(const StrategyUse& use);

// Luminance times solid angle of every texel, row-major; solid angle alone for a black map.
std::vector<double> TexelImportance(const Texels& texels);

}  // namespace skywave
