#include "lights/strategies/lights.h"

#include "kernels/lights/environment.h"
#include "lights/light_sets/light_builder.h"

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
                               const LightSet& lights, bool all)
    : name_(name),
      note_(NoteOfLights(lights)),
      texels_(map, Image(map.latlong->width, map.latlong->height)),
      lights_(lights.lights, map.map_from_world),
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

namespace {

template <LightSource kSource>
std::unique_ptr<EnvStrategy> MakeLights(const EnvironmentMap& map, const StrategyValues& values) {
  LightOptions options = ReadLightOptions(values);
  options.source = kSource;
  return std::make_unique<LightsStrategy>(ToString(kSource), map, options, ReadPickAll(values));
}

std::span<const StrategyParameter> Parameters() {
  static const std::vector<StrategyParameter> parameters = [] {
    std::vector<StrategyParameter> all = {kPickParameter};
    all.insert(all.end(), LightParameters().begin(), LightParameters().end());
    return all;
  }();
  return parameters;
}

}  // namespace

StrategyFactory MedianCutFactory() {
  return {"median-cut", "directional lights of regions of equal energy (Debevec 2005)",
          Parameters(), MakeLights<LightSource::kMedianCut>};
}

StrategyFactory VarianceCutFactory() {
  return {"variance-cut", "directional lights of regions of least variance", Parameters(),
          MakeLights<LightSource::kVarianceCut>};
}

StrategyFactory StructuredFactory() {
  return {"structured",
          "directional lights of strata by thresholds and distance (Agarwal et al. "
          "2003)",
          Parameters(), MakeLights<LightSource::kStructured>};
}

StrategyFactory KMeansFactory() {
  return {"k-means", "directional lights by k-means clustering (LightGen, Cohen and Debevec 2001)",
          Parameters(), MakeLights<LightSource::kKMeans>};
}

StrategyFactory KolligKellerFactory() {
  return {"kollig-keller", "directional lights by Lloyd's relaxation (Kollig and Keller 2003)",
          Parameters(), MakeLights<LightSource::kKolligKeller>};
}

StrategyFactory PenroseFactory() {
  return {"penrose", "directional lights by the Penrose tiling (Ostromoukhov et al. 2004)",
          Parameters(), MakeLights<LightSource::kPenrose>};
}

StrategyFactory PolyominoFactory() {
  return {"polyomino", "directional lights by a tiling of polyominoes (Ostromoukhov 2007)",
          Parameters(), MakeLights<LightSource::kPolyomino>};
}

}  // namespace skywave
