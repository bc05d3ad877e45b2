#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "lights/strategy.h"
#include "lights/strategy_baselines.h"
#include "lights/strategy_importance.h"

namespace skywave {
namespace {

constexpr StrategyParameter kImportanceParameters[] = {
    {"compensate", "0", "1: subtract the mean from the density (needs BSDF sampling beside it)"}};

const StrategyFactory kStrategies[] = {
    {"importance", "2D inversion: density proportional to the map's luminance",
     kImportanceParameters,
     [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
       return std::make_unique<ImportanceStrategy>(map, BoolValue(values, "compensate"));
     }},
    {"uniform",
     "uniform over the sphere (baseline)",
     {},
     [](const EnvironmentMap& map, const StrategyValues&) -> std::unique_ptr<EnvStrategy> {
       return std::make_unique<UniformStrategy>(map);
     }},
    {"cosine",
     "cosine about the shading normal (baseline)",
     {},
     [](const EnvironmentMap& map, const StrategyValues&) -> std::unique_ptr<EnvStrategy> {
       return std::make_unique<CosineStrategy>(map);
     }},
};

[[noreturn]] void ThrowUsage(const std::string& reason) {
  throw InputError(InputPosition::File("--strategy"), reason, kExitUsage);
}

// Splits "key=value,key=value" and completes it by defaults.
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

std::span<const StrategyFactory> Strategies() { return kStrategies; }

std::unique_ptr<EnvStrategy> MakeStrategy(const std::string& specification,
                                          const EnvironmentMap& map) {
  const std::size_t colon = specification.find(':');
  const std::string name = specification.substr(0, colon);
  for (const StrategyFactory& factory : kStrategies) {
    if (factory.name != name) continue;
    const std::string_view values = colon == std::string::npos
                                        ? std::string_view()
                                        : std::string_view(specification).substr(colon + 1);
    return factory.make(map, ParseValues(factory, values));
  }
  std::string names;
  for (const StrategyFactory& factory : kStrategies) {
    names += (names.empty() ? "" : ", ") + std::string(factory.name);
  }
  ThrowUsage(fmt::format("there is no strategy '{}'; there are {}", name, names));
}

bool BoolValue(const StrategyValues& values, std::string_view key) {
  const auto found = std::find_if(values.begin(), values.end(),
                                  [&](const auto& value) { return value.first == key; });
  const std::string& text = found->second;
  if (text == "1" || text == "true" || text == "on") return true;
  if (text == "0" || text == "false" || text == "off") return false;
  ThrowUsage(fmt::format("{}={} is neither 0 nor 1", key, text));
}

}  // namespace skywave
