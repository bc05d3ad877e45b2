// product: directions drawn in proportion to the map times the BSDF, as far as a coarse map knows
// them (Conty Estevez and Lecocq 2018): the map is cut into cells of little spread; a surface
// weighs every cell by its light times the BSDF in its centre, picks one, and a texel of it by
// luminance. Light below the horizon is never drawn, glossy surfaces look where they reflect.
//
// Parameters
//   cells=96   number of cells (up to 256): more follow map and BSDF closer and cost more to weigh
//
// Unbiased, with a density, so it takes part in multiple importance sampling. The cells come from
// variance cuts, which end where the light is: a sun is a cell of its own.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "kernels/bsdf/product.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/cell_sampler.h"
#include "lights/tables/cells.h"
#include "lights/tables/texels.h"

namespace skywave {

// Cuts the light that samples will find into cells, so that every texel with light has one. A black
// map is one cell with something in it.
LightSet CutCells(const SphereMap& map, int cells);
std::vector<LightCell> MakeLightCells(const SphereMap& map, const LightSet& set,
                                      const std::array<float, 9>& map_from_world);

inline constexpr int kDefaultProductCells = 96;
inline constexpr std::string_view kDefaultProductCellsText = "96";
static_assert((kDefaultProductCellsText[0] - '0') * 10 + kDefaultProductCellsText[1] - '0' ==
              kDefaultProductCells);

class ProductStrategy final : public EnvStrategy {
 public:
  ProductStrategy(const EnvironmentMap& map, int cells)
      : ProductStrategy(map, map.latlong, cells) {}
  // Only `part` of the map acts as a light.
  ProductStrategy(const EnvironmentMap& map, const Image& part, int cells);

  std::string_view name() const override { return "product"; }
  bool depends_on_surface() const override { return true; }
  std::size_t table_bytes() const override;
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  CellsView InCells() const;

  Texels texels_;
  CellMap cell_of_texel_;  // no kNoCell: texels without light belong to cell 0
  std::vector<LightCell> cells_;
  std::optional<CellSampler> sampler_;
  std::vector<float> density_;  // of each texel inside its cell [1/sr]
};

}  // namespace skywave
