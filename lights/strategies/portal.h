// portal: directions drawn through portals, the windows of a room (Bitterli et al. 2015): a surface
// draws in proportion to the luminance of what it sees of the map through them, and nothing that
// walls hide. Of several portals one is picked by the energy seen through it.
//
// Parameters
//   texels=1024    rows and columns of the map as a portal sees it, 16 to 4096: more follow small
//                  suns closer and fall out of caches
//   share=0.125    part of the samples that is drawn like those of `importance`, 0 to 0.9, which
//                  finds what comes in elsewhere. With 0 that is left to BSDF sampling, so it needs
//                  it beside it and is refused with --no-mis.
//
// Unbiased wherever the portals are, with a density. Portals come with the map (EnvironmentMap):
// from the scene or from --portal; without any, the strategy is refused. Surfaces in front of them,
// and surfaces that see nothing bright through any, draw as `importance` does.
#pragma once

#include "lights/strategies/strategy.h"
#include "lights/tables/inversion_table.h"
#include "lights/tables/portal_tables.h"
#include "lights/tables/texels.h"

namespace skywave {

class PortalStrategy final : public EnvStrategy {
 public:
  PortalStrategy(const EnvironmentMap& map, std::uint32_t texels, double share);

  std::string_view name() const override { return "portal"; }
  std::size_t table_bytes() const override {
    return texels_.bytes() + inversion_.bytes() + portals_.bytes();
  }
  bool complete() const override { return share_ > 0; }
  bool depends_on_surface() const override { return true; }
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  Texels texels_;
  InversionTable inversion_;
  PortalTables portals_;
  float share_;
};

}  // namespace skywave
