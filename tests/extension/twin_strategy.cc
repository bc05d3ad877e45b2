// The uniform strategy under another name.
#include "lights/strategies/baselines.h"

namespace skywave {

StrategyFactory TwinFactory() {
  return {"twin",
          "uniform under another name",
          {},
          [](const EnvironmentMap& map, const StrategyValues&) -> std::unique_ptr<EnvStrategy> {
            return std::make_unique<UniformStrategy>(map);
          }};
}

}  // namespace skywave
