#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "lights/light_sets/light_builder.h"
#include "lights/strategies/strategy.h"

namespace skywave {

// The strategies, one line each, in the order in which they are listed. A file of this folder
// defines NameFactory() and whatever it makes.
#define SKYWAVE_STRATEGIES(STRATEGY) \
  STRATEGY(Importance)               \
  STRATEGY(Warp)                     \
  STRATEGY(Alias)                    \
  STRATEGY(Uniform)                  \
  STRATEGY(Cosine)                   \
  STRATEGY(Bsdf)                     \
  STRATEGY(MedianCut)                \
  STRATEGY(VarianceCut)              \
  STRATEGY(Structured)               \
  STRATEGY(KMeans)                   \
  STRATEGY(KolligKeller)             \
  STRATEGY(Penrose)                  \
  STRATEGY(Polyomino)                \
  STRATEGY(Presampled)               \
  STRATEGY(Product)                  \
  STRATEGY(Portal)                   \
  STRATEGY(Visibility)               \
  STRATEGY(Ris)                      \
  STRATEGY(Hybrid)                   \
  STRATEGY(Automatic)

#define SKYWAVE_DECLARE(name) StrategyFactory name##Factory();
SKYWAVE_STRATEGIES(SKYWAVE_DECLARE)
#undef SKYWAVE_DECLARE

namespace {

[[noreturn]] void ThrowUsage(const std::string& reason) {
  throw OptionError("strategy", "", reason);
}

// Splits "key=value,key=value" and adds the defaults of all other keys.
StrategyValues ParseValues(const StrategyFactory& factory, std::string_view text,
                           const StrategyUse& use) {
  StrategyValues values;
  for (const StrategyParameter& parameter : factory.parameters) {
    values.emplace_back(parameter.key, parameter.default_for != nullptr
                                           ? parameter.default_for(use)
                                           : std::string(parameter.default_value));
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
      ThrowUsage(fmt::format("'{}' is not a parameter of {}; it takes {}", item, factory.name,
                             keys.empty() ? "none" : keys + " as key=value"));
    }
    found->second = item.substr(equals + 1);
  }
  return values;
}

}  // namespace

std::span<const StrategyFactory> Strategies() {
#define SKYWAVE_MAKE(name) name##Factory(),
  static const StrategyFactory strategies[] = {SKYWAVE_STRATEGIES(SKYWAVE_MAKE)};
#undef SKYWAVE_MAKE
  return strategies;
}

std::vector<std::string> FilesOfStrategy(const std::string& specification) {
  const std::string key = std::string(kFileParameter.key) + "=";
  std::vector<std::string> files;
  for (std::size_t begin = specification.find(':'); begin != std::string::npos;
       begin = specification.find(',', begin)) {
    ++begin;
    if (specification.compare(begin, key.size(), key) != 0) continue;
    const std::size_t end = specification.find(',', begin);
    files.push_back(specification.substr(begin + key.size(), end - begin - key.size()));
  }
  return files;
}

bool CanEmit(const EnvStrategy& strategy) {
  const LightPlan plan = strategy.Plan(1);
  return !strategy.depends_on_surface() && strategy.complete() && plan.fixed == 0 &&
         plan.drawn == 1;
}

std::unique_ptr<EnvStrategy> MakeStrategy(const std::string& specification,
                                          const EnvironmentMap& map, const StrategyUse& use) {
  const std::size_t colon = specification.find(':');
  const std::string name = specification.substr(0, colon);
  for (const StrategyFactory& factory : Strategies()) {
    if (factory.name != name) continue;
    const std::string_view values = colon == std::string::npos
                                        ? std::string_view()
                                        : std::string_view(specification).substr(colon + 1);
    return factory.make(map, ParseValues(factory, values, use));
  }
  std::string names;
  for (const StrategyFactory& factory : Strategies()) {
    names += (names.empty() ? "" : ", ") + std::string(factory.name);
  }
  ThrowUsage(fmt::format("there is no strategy '{}'; there are {}", name, names));
}

}  // namespace skywave
