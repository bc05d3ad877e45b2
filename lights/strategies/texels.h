// Strategies that draw single texels in proportion to the luminance of the map, beside importance.
//
// warp   hierarchical warp (Clarberg et al. 2005): both uniforms are split level by level down a
//        pyramid. Keeps the stratification of the points it is fed.
// alias  one alias table over all texels (Walker 1977): constant time, not monotone. Kept to show
//        what losing stratification costs.
// presampled  a few hundred cells, placed by `from` (T 7.3): a cell is picked by its energy, then
//   mode=fixed     the direction of the cell's light, worth its whole irradiance (the thesis):
//                  biased, a finite set of directions
//   mode=jittered  a texel in the cell by importance: unbiased, with a density
//   lights=360 cells (auto:BIAS with mode=fixed), from=penrose, and the other parameters of
//   directional lights; or file=FILE, cells that `skywave probe presample` or others have written.
#pragma once

#include "lights/strategies/strategy.h"
#include "lights/tables/cell_sampler.h"
#include "lights/tables/oriented_tables.h"
#include "lights/tables/texels.h"

namespace skywave {

class WarpStrategy final : public EnvStrategy {
 public:
  explicit WarpStrategy(const EnvironmentMap& map)
      : tables_(std::make_shared<const Tables>(map), map) {}
  std::string_view name() const override { return "warp"; }
  std::size_t table_bytes() const override;
  std::unique_ptr<EnvStrategy> Turned(const EnvironmentMap& map) const override;
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  struct Tables {
    explicit Tables(const EnvironmentMap& map);
    Texels texels;
    std::vector<std::vector<WarpRecord>> records;  // coarsest level first
    WarpView warp;
    std::vector<float> density;  // of each texel [1/sr]
  };
  explicit WarpStrategy(OrientedTables<Tables> tables) : tables_(std::move(tables)) {}

  OrientedTables<Tables> tables_;
};

// alias, and presampled with mode=jittered.
class CellStrategy final : public EnvStrategy {
 public:
  CellStrategy(std::string_view name, const EnvironmentMap& map, const CellMap& cell_of_texel,
               std::uint32_t cells)
      : name_(name), tables_(std::make_shared<const Tables>(map, cell_of_texel, cells), map) {}
  std::string_view name() const override { return name_; }
  std::size_t table_bytes() const override {
    return tables_->texels.bytes() + tables_->sampler.bytes();
  }
  std::unique_ptr<EnvStrategy> Turned(const EnvironmentMap& map) const override;
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  struct Tables {
    Tables(const EnvironmentMap& map, const CellMap& cell_of_texel, std::uint32_t cells);
    Texels texels;
    CellSampler sampler;
  };
  CellStrategy(std::string_view name, OrientedTables<Tables> tables)
      : name_(name), tables_(std::move(tables)) {}

  std::string_view name_;
  OrientedTables<Tables> tables_;
};

}  // namespace skywave
