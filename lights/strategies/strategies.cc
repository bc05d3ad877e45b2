#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/error.h"
#include "lights/light_sets/light_builder.h"
#include "lights/strategies/baselines.h"
#include "lights/strategies/hybrid.h"
#include "lights/strategies/importance.h"
#include "lights/strategies/lights.h"
#include "lights/strategies/product.h"
#include "lights/strategies/ris.h"
#include "lights/strategies/strategy.h"
#include "lights/strategies/texels.h"

namespace skywave {
namespace {

using Made = std::unique_ptr<EnvStrategy>;

constexpr StrategyParameter kImportanceParameters[] = {
    {"compensate", "0",
     "share of the mean that the density leaves to BSDF sampling, 0 to 1: 1 / light samples"}};

constexpr StrategyParameter kProductParameters[] = {
    {"cells", "96", "number of cells that the map is cut into, up to 256"}};

constexpr StrategyParameter kRisParameters[] = {
    {"map", "4", "candidates from the map, 1 to 256"},
    {"bsdf", "1", "candidates from the BSDF, 0 to 256"}};

std::vector<StrategyParameter> WithLights(std::vector<StrategyParameter> parameters) {
  parameters.insert(parameters.end(), LightParameters().begin(), LightParameters().end());
  return parameters;
}

std::span<const StrategyParameter> LightsParameters() {
  static const std::vector<StrategyParameter> parameters = WithLights({kPickParameter});
  return parameters;
}
std::span<const StrategyParameter> PresampledParameters() {
  static const std::vector<StrategyParameter> parameters = [] {
    std::vector<StrategyParameter> all = WithLights(
        {{"mode", "jittered", "fixed: the cell's light; jittered: a texel of it by importance"},
         kFromParameter});
    for (StrategyParameter& parameter : all) {
      if (parameter.key == "lights") parameter = {"lights", "360", "number of cells"};
    }
    return all;
  }();
  return parameters;
}

template <LightSource kSource>
Made MakeLightsStrategy(const EnvironmentMap& map, const StrategyValues& values) {
  constexpr std::string_view kNames[] = {"penrose", "median-cut", "variance-cut"};
  LightOptions options = ReadLightOptions(values);
  options.source = kSource;
  return std::make_unique<LightsStrategy>(kNames[int(kSource)], map, options, ReadPickAll(values));
}

Made MakeAlias(const EnvironmentMap& map, const StrategyValues&) {
  return std::make_unique<CellStrategy>("alias", map, CellMap(map.latlong.rgb.size() / 3, 0), 1);
}

Made MakePresampled(const EnvironmentMap& map, const StrategyValues& values) {
  constexpr std::string_view kModes[] = {"fixed", "jittered"};
  LightOptions options = ReadLightOptions(values);
  options.source = ReadLightSource(values);
  if (ChoiceValue(values, "mode", kModes) == 0) {
    return std::make_unique<LightsStrategy>("presampled", map, options, /*all=*/false);
  }
  // The light that samples will find is cut into cells, so that every texel with light has one.
  const Image held = Texels(map).Held();
  const LightSet cells = BuildLights(MakeSphereMap(held), options);
  // A black map has no cells: one that is all of it is sampled uniformly.
  if (cells.lights.empty()) return MakeAlias(map, values);
  return std::make_unique<CellStrategy>("presampled", map, cells.cell_of_texel,
                                        std::uint32_t(cells.lights.size()));
}

const std::vector<StrategyFactory>& Table() {
  static const std::vector<StrategyFactory> table = {
      {"importance", "2D inversion: density proportional to the map's luminance",
       kImportanceParameters,
       [](const EnvironmentMap& map, const StrategyValues& values) -> Made {
         return std::make_unique<ImportanceStrategy>(map, NumberValue(values, "compensate", 0, 1));
       }},
      {"warp",
       "hierarchical warp down a pyramid of luminance",
       {},
       [](const EnvironmentMap& map, const StrategyValues&) -> Made {
         return std::make_unique<WarpStrategy>(map);
       }},
      {"alias", "one alias table over all texels (loses stratification)", {}, MakeAlias},
      {"uniform",
       "uniform over the sphere (baseline)",
       {},
       [](const EnvironmentMap& map, const StrategyValues&) -> Made {
         return std::make_unique<UniformStrategy>(map);
       }},
      {"cosine",
       "cosine about the shading normal (baseline)",
       {},
       [](const EnvironmentMap& map, const StrategyValues&) -> Made {
         return std::make_unique<CosineStrategy>(map);
       }},
      {"bsdf",
       "BSDF sampling alone (baseline)",
       {},
       [](const EnvironmentMap& map, const StrategyValues&) -> Made {
         return std::make_unique<BsdfStrategy>(map);
       }},
      {"median-cut", "directional lights of regions of equal energy (Debevec 2005)",
       LightsParameters(), MakeLightsStrategy<LightSource::kMedianCut>},
      {"variance-cut", "directional lights of regions of least variance", LightsParameters(),
       MakeLightsStrategy<LightSource::kVarianceCut>},
      {"penrose", "directional lights by the Penrose tiling (Ostromoukhov et al. 2004)",
       LightsParameters(), MakeLightsStrategy<LightSource::kPenrose>},
      {"presampled", "cells of the map, picked by energy (T 7.3)", PresampledParameters(),
       MakePresampled},
      {"product", "cells of the map picked by light times BSDF (Conty Estevez and Lecocq 2018)",
       kProductParameters,
       [](const EnvironmentMap& map, const StrategyValues& values) -> Made {
         return std::make_unique<ProductStrategy>(
             map, IntValue(values, "cells", 1, int(kMaxProductCells)));
       }},
      {"ris", "the best of several candidates from map and BSDF (Talbot et al. 2005)",
       kRisParameters,
       [](const EnvironmentMap& map, const StrategyValues& values) -> Made {
         return std::make_unique<RisStrategy>(
             map, CandidateCounts{.map = std::uint32_t(IntValue(values, "map", 1, 256)),
                                  .bsdf = std::uint32_t(IntValue(values, "bsdf", 0, 256))});
       }},
      {"hybrid", "the bright part as lights, the rest at random (T 7.4)", HybridParameters(),
       [](const EnvironmentMap& map, const StrategyValues& values) -> Made {
         return std::make_unique<HybridStrategy>(map, ReadHybridOptions(values));
       }},
  };
  return table;
}

[[noreturn]] void ThrowUsage(const std::string& reason) {
  throw OptionError("strategy", "", reason);
}

// Splits "key=value,key=value" and adds the defaults of all other keys.
StrategyValues ParseValues(const StrategyFactory& factory, std::string_view text) {
  StrategyValues values;
  for (const StrategyParameter& parameter : factory.parameters) {
    values.emplace_back(parameter.key, parameter.default_value);
  }
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
    const std::size_t equals = item.find('=');
    const auto found = std::find_if(values.begin(), values.end(), [&](const auto& value) {
      return value.first == item.substr(0, equals);
    });
    if (equals == std::string_view::npos || found == values.end()) {
      std::string keys;
      for (const auto& value : values) keys += (keys.empty() ? "" : ", ") + value.first;
      ThrowUsage(fmt::format("'{}' is no parameter of {}; it takes {}", item, factory.name,
                             keys.empty() ? "none" : keys + " as key=value"));
    }
    found->second = item.substr(equals + 1);
  }
  return values;
}

}  // namespace

std::span<const StrategyFactory> Strategies() { return Table(); }

bool CanEmit(const EnvStrategy& strategy) {
  const LightPlan plan = strategy.Plan(1);
  return !strategy.depends_on_surface() && strategy.complete() && plan.fixed == 0 &&
         plan.drawn == 1;
}

std::unique_ptr<EnvStrategy> MakeStrategy(const std::string& specification,
                                          const EnvironmentMap& map) {
  const std::size_t colon = specification.find(':');
  const std::string name = specification.substr(0, colon);
  for (const StrategyFactory& factory : Strategies()) {
    if (factory.name != name) continue;
    const std::string_view values = colon == std::string::npos
                                        ? std::string_view()
                                        : std::string_view(specification).substr(colon + 1);
    return factory.make(map, ParseValues(factory, values));
  }
  std::string names;
  for (const StrategyFactory& factory : Strategies()) {
    names += (names.empty() ? "" : ", ") + std::string(factory.name);
  }
  ThrowUsage(fmt::format("there is no strategy '{}'; there are {}", name, names));
}

namespace {

const std::string& TextValue(const StrategyValues& values, std::string_view key) {
  return std::find_if(values.begin(), values.end(),
                      [&](const auto& value) { return value.first == key; })
      ->second;
}

}  // namespace

bool BoolValue(const StrategyValues& values, std::string_view key) {
  const std::string& text = TextValue(values, key);
  if (text == "1" || text == "true" || text == "on") return true;
  if (text == "0" || text == "false" || text == "off") return false;
  ThrowUsage(fmt::format("{}={} is neither 0 nor 1", key, text));
}

double NumberValue(const StrategyValues& values, std::string_view key, double low, double high) {
  const std::string& text = TextValue(values, key);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() ||
      !(value >= low && value <= high)) {
    ThrowUsage(fmt::format("{}={} is no number from {} to {}", key, text, low, high));
  }
  return value;
}

int IntValue(const StrategyValues& values, std::string_view key, int low, int high) {
  const double value = NumberValue(values, key, low, high);
  if (value != int(value)) ThrowUsage(fmt::format("{}={} is no whole number", key, value));
  return int(value);
}

std::size_t ChoiceValue(const StrategyValues& values, std::string_view key,
                        std::span<const std::string_view> choices) {
  const std::string& text = TextValue(values, key);
  const auto found = std::find(choices.begin(), choices.end(), text);
  if (found == choices.end()) {
    ThrowUsage(fmt::format("{}={} is none of {}", key, text, fmt::join(choices, ", ")));
  }
  return std::size_t(found - choices.begin());
}

}  // namespace skywave
