// auto: the strategy for which variance times cost is least in a pilot of the frame
// (wavefront/policies/strategy_pilot.h). It chooses among `importance`, `product`, `visibility`
// and, where there are portals, `portal`.
//
// Parameters
//   compensate=1/n  that of `importance`, which `visibility` has too
//
// Unbiased, as all of them are, since the pilot has random numbers of its own. It chooses as if
// there were no control variate. Before the pilot has chosen, and with `photon` and `vpl`, it acts
// as `importance`; integrators whose light paths start with the strategy's own samples refuse it.
#pragma once

#include <optional>
#include <vector>

#include "lights/strategies/importance.h"
#include "lights/strategies/portal.h"
#include "lights/strategies/product.h"
#include "lights/strategies/strategy.h"
#include "lights/strategies/visibility.h"

namespace skywave {

class AutomaticStrategy final : public EnvStrategy {
 public:
  AutomaticStrategy(const EnvironmentMap& map, double compensate);

  std::string_view name() const override { return "auto"; }
  std::size_t table_bytes() const override;
  bool complete() const override { return importance_.complete(); }
  // Whatever the pilot chooses may ask the surface.
  bool depends_on_surface() const override { return true; }
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override {
    importance_.Sample(points, uniforms, n, call, out);
  }
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override {
    importance_.EvaluateEscaped(points, n, samples, rows);
  }
  std::span<const StrategyCandidate> candidates() const override { return candidates_; }

 private:
  ImportanceStrategy importance_;
  ProductStrategy product_;
  VisibilityStrategy visibility_;
  std::optional<PortalStrategy> portal_;
  std::vector<StrategyCandidate> candidates_;
};

}  // namespace skywave
