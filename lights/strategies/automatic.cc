#include "lights/strategies/automatic.h"

namespace skywave {
namespace {

// The default of the strategies themselves.
constexpr std::uint32_t kPortalTexels = 1024;
constexpr double kPortalShare = 0.125;

}  // namespace

AutomaticStrategy::AutomaticStrategy(const EnvironmentMap& map, double compensate)
    : importance_(map, compensate),
      product_(map, kDefaultProductCells),
      visibility_(map, {.compensate = compensate}) {
  // The costs are those of renders of Sponza and of the built-in scene `room`, where a ray takes
  // about 200 ns.
  candidates_ = {{&importance_, 0.2}, {&product_, 1.5}, {&visibility_, 0.6}};
  if (!map.portals.empty()) {
    portal_.emplace(map, kPortalTexels, kPortalShare);
    candidates_.push_back({&*portal_, 2.0});
  }
}

std::size_t AutomaticStrategy::table_bytes() const {
  std::size_t bytes = 0;
  for (const StrategyCandidate& candidate : candidates_) bytes += candidate.strategy->table_bytes();
  return bytes;
}

StrategyFactory AutomaticFactory() {
  static constexpr StrategyParameter kParameters[] = {
      {"compensate", "1/n", "that of importance", DefaultCompensation}};
  return {
      "auto", "the strategy that does best in a pilot", kParameters,
      [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
        return std::make_unique<AutomaticStrategy>(map, NumberValue(values, "compensate", 0, 1));
      }};
}

}  // namespace skywave
