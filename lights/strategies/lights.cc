#include "lights/strategies/lights.h"

#include "kernels/lights/environment.h"

namespace skywave {

DirectionalLights MakeLights(const EnvironmentMap& map, const Image& part,
                             const LightOptions& options) {
  return {BuildLights(MakeSphereMap(part), options).lights, map.map_from_world};
}

bool ReadPickAll(const StrategyValues& values) {
  constexpr std::string_view kChoices[] = {"all", "power"};
  return ChoiceValue(values, kPickParameter.key, kChoices) == 0;
}

LightsStrategy::LightsStrategy(std::string_view name, const EnvironmentMap& map,
                               const LightOptions& options, bool all)
    : name_(name),
      texels_(map, Image(map.latlong.width, map.latlong.height)),
      lights_(MakeLights(map, map.latlong, options)),
      all_(all) {}

LightPlan LightsStrategy::Plan(std::uint32_t requested) const {
  if (all_ || lights_.size() == 0) return {.fixed = lights_.size(), .drawn = 0};
  return {.drawn = requested};
}

void LightsStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                            LightCall call, const LightColumns& out) const {
  if (all_) {
    FillDirectional(lights_[call.index], n, out);
  } else {
    PickDirectional(lights_.records(), lights_.tree(), uniforms.u, n, call.samples(), out);
  }
}

void LightsStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float,
                                     const EscapeColumns& rows) const {
  skywave::EvaluateEscaped(texels_.view(), {}, n, 0, rows);
}

}  // namespace skywave
