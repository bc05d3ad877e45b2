#include "lights/strategies/hybrid.h"

#include <algorithm>
#include <numbers>

#include "base/error.h"
#include "kernels/borrowed.h"
#include "kernels/lights/environment.h"
#include "kernels/lights/texel_samplers.h"
#include "lights/strategies/lights.h"

namespace skywave {
namespace {

constexpr std::string_view kDivisions[] = {"variation", "p", "lights"};
constexpr std::string_view kRests[] = {"importance", "presampled"};

struct StratumColumns {
  float* u;  // in [0, 1)

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.u);
  }
};

// Stratum B reuses the rescaled uniform (SplitUniforms). t_far of light samples is free until they
// are evaluated, so it holds that uniform.
struct StratumUniforms : Borrowed<StratumColumns> {
  StratumUniforms(const LightColumns& samples, std::uint32_t n)
      : Borrowed({samples.t_far}, n, "StratumUniforms") {}
};

// Returns luminance of the light times solid angle over A; solid angle alone where that is black.
std::vector<double> ImportanceOfA(const Texels& light, const SphereMap& map, const Strata& strata) {
  std::vector<double> importance(map.texels());
  double total = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(map.width) + std::size_t(x);
      if (strata.in_a[i] == 0) continue;
      total += importance[i] =
          light.Luminance(std::uint32_t(x), std::uint32_t(y)) * map.solid_angle[std::size_t(y)];
    }
  }
  if (total <= 0) {
    for (std::size_t i = 0; i < importance.size(); ++i) {
      importance[i] = map.solid_angle[i / std::size_t(map.width)];
    }
  }
  return importance;
}

}  // namespace

HybridStrategy::HybridStrategy(const EnvironmentMap& map, const HybridOptions& options)
    : options_(options) {
  // A and B divide the light that samples will find, and exactly that.
  const Image held = Texels(map).Held();
  const SphereMap sphere = MakeSphereMap(held);
  const Strata strata = DivideMap(sphere, options.strata);
  const Image a = StratumImage(sphere, strata, true), b = StratumImage(sphere, strata, false);
  const SphereMap sphere_a = MakeSphereMap(a);
  share_ = sphere.energy > 0 ? float(std::clamp(sphere_a.energy / sphere.energy, 0.0, 1.0)) : 0;
  LightOptions lights_of_a = options.lights;
  if (lights_of_a.bias && share_ > 0) lights_of_a.bias = *lights_of_a.bias / share_;
  LightSet lights = BuildLights(sphere_a, lights_of_a);
  lights.bias *= share_;
  note_ = NoteOfLights(lights);
  lights_.emplace(lights.lights, map.map_from_world);

  // An escaped ray sees as a light what random samples could have found: B, and A if its cells are
  // sampled inside, but not what directional lights stand for.
  const int width = map.latlong.width, height = map.latlong.height;
  if (options.presampled) {
    LightOptions rest = options.lights;
    rest.lights = options.rest_samples;
    rest.bias.reset();
    rest.cluster.reset();
    rest_lights_.emplace(MakeLights(map, b, rest));
    texels_.emplace(map, options.inside ? a : Image(width, height));
  } else {
    texels_.emplace(map, options.inside ? held : b);
    if (options.inside) rest_texels_.emplace(map, b);
    Texels& rest = rest_texels_ ? *rest_texels_ : *texels_;
    double compensate = 0;
    rest_table_.emplace(rest, BaseLuminance(rest, compensate));
  }
  if (options.inside && !lights.lights.empty()) {
    CellMap cells = lights.cell_of_texel;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (strata.in_a[i] == 0) cells[i] = kNoCell;
    }
    cells_.emplace(width, height, ImportanceOfA(*texels_, sphere, strata), cells, lights_->size());
    cell_density_ = cells_->DensityInCells(cells);
  }
}

std::size_t HybridStrategy::table_bytes() const {
  return texels_->bytes() + lights_->bytes() + (cells_ ? cells_->bytes() : 0) +
         cell_density_.size() * sizeof(float) + (rest_table_ ? rest_table_->bytes() : 0) +
         (rest_texels_ ? rest_texels_->bytes() : 0) + (rest_lights_ ? rest_lights_->bytes() : 0);
}

bool HybridStrategy::RestIsDark() const {
  return share_ >= 1 || (rest_lights_ && rest_lights_->size() == 0);
}

LightPlan HybridStrategy::Plan(std::uint32_t requested) const {
  // A stratum without light needs no samples.
  if (options_.all) {
    return {.fixed = lights_->size(),
            .drawn = RestIsDark() ? 0 : requested,
            .random_fixed = options_.inside};
  }
  return {.drawn = RestIsDark() && lights_->size() == 0 ? 0 : requested};
}

void HybridStrategy::SampleRest(const UniformColumns& uniforms, std::uint32_t n, float samples,
                                const LightColumns& out) const {
  if (rest_lights_) {
    PickDirectional(rest_lights_->records(), rest_lights_->tree(), uniforms.u, n, samples, out);
  } else {
    SampleTexels(texels_->view(), rest_table_->view(), uniforms, n, samples, out);
  }
}

void HybridStrategy::Sample(const ShadePoints&, const UniformColumns& uniforms, std::uint32_t n,
                            LightCall call, const LightColumns& out) const {
  const float samples = call.samples();
  if (options_.all && call.index < lights_->size()) {
    if (options_.inside) {
      SampleOneCell(texels_->view(), cells_->view(), call.index, cells_->Scale(call.index),
                    uniforms, n, out);
    } else {
      FillDirectional((*lights_)[call.index], n, out);
    }
  } else if (options_.all || lights_->size() == 0) {
    SampleRest(uniforms, n, samples, out);
  } else if (RestIsDark()) {
    PickDirectional(lights_->records(), lights_->tree(), uniforms.u, n, samples, out);
  } else {
    // Uniforms below the share of A pick one of its lights, those above it draw from B.
    {
      const StratumUniforms of_b(out, n);
      SplitUniforms(uniforms.u, n, share_, of_b->u);
      SampleRest({.u = of_b->u, .v = uniforms.v}, n, samples * (1 - share_), out);
    }
    PickOverSplit(lights_->records(), lights_->tree(), uniforms.u, n, share_, samples, out);
  }
}

void HybridStrategy::EvaluateEscaped(const ShadePoints&, std::uint32_t n, float samples,
                                     const EscapeColumns& rows) const {
  const float share_of_rest = RestIsDark() ? 0 : options_.all ? 1 : 1 - share_;
  TexelDensity density = {.fixed = options_.inside ? cell_density_.data() : nullptr};
  InversionView inversion;
  if (rest_table_) {
    inversion = rest_table_->view();
    density.inversion = &inversion;
  }
  if (cell_density_.empty()) density.fixed = nullptr;
  skywave::EvaluateEscaped(texels_->view(), density, n, samples * share_of_rest, rows);
}

std::span<const StrategyParameter> HybridParameters() {
  static const std::vector<StrategyParameter> parameters = [] {
    std::vector<StrategyParameter> all = {
        {"strata", "variation", "where the bright part A ends: variation, p or lights"},
        {"p", "0.5", "fraction of the energy in A (strata=p)"},
        {"angle", "10", "degrees between the lights A has room for (strata=lights)"},
        kFromParameter};
    all.insert(all.end(), LightParameters().begin(), LightParameters().end());
    all.push_back(kPickParameter);
    all.push_back({"rest", "importance", "how B is drawn: importance or presampled"});
    all.push_back({"rest-samples", "360", "cells of B (rest=presampled)"});
    all.push_back({"inside", "0", "1: a random sample inside each of A's cells, not its light"});
    return all;
  }();
  return parameters;
}

HybridOptions ReadHybridOptions(const StrategyValues& values) {
  HybridOptions options;
  options.lights = ReadLightOptions(values);
  options.strata = {.kind = StrataRequest::Kind(ChoiceValue(values, "strata", kDivisions)),
                    .fraction = NumberValue(values, "p", 0, 1),
                    .lights = options.lights.lights,
                    .separation = NumberValue(values, "angle", 0, 360) * std::numbers::pi / 180};
  options.lights.source = ReadLightSource(values);
  options.all = ReadPickAll(values);
  options.presampled = ChoiceValue(values, "rest", kRests) == 1;
  options.rest_samples = IntValue(values, "rest-samples", 1, 30000);
  options.inside = BoolValue(values, "inside");
  if (options.inside && !options.all) {
    throw OptionError("strategy", "hybrid", "inside=1 needs pick=all");
  }
  const bool for_lights = options.strata.kind == StrataRequest::Kind::kLights;
  if (options.lights.bias && (options.inside || for_lights)) {
    throw OptionError("strategy", "hybrid",
                      options.inside
                          ? "lights=auto needs inside=0: samples inside cells are unbiased"
                          : "lights=auto needs strata=variation or strata=p");
  }
  return options;
}

StrategyFactory HybridFactory() {
  return {
      "hybrid", "the bright part as lights, the rest at random (T 7.4)", HybridParameters(),
      [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
        return std::make_unique<HybridStrategy>(map, ReadHybridOptions(values));
      }};
}

}  // namespace skywave
