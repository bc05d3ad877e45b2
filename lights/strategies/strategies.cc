#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/error.h"
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

namespace {

const std::string& TextValue(const StrategyValues& values, std::string_view key) {
  return std::find_if(values.begin(), values.end(),
                      [&](const auto& value) { return value.first == key; })
      ->second;
}

// Returns nothing for a text that is not a number or out of range.
std::optional<double> ParseNumber(std::string_view text, double low, double high) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!(value >= low && value <= high)) return std::nullopt;
  return value;
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
  const std::optional<double> value = ParseNumber(text, low, high);
  if (!value) ThrowUsage(fmt::format("{}={} is not a number from {} to {}", key, text, low, high));
  return *value;
}

std::optional<double> AutoValue(const StrategyValues& values, std::string_view key, double low,
                                double high) {
  const std::string& text = TextValue(values, key);
  if (!text.starts_with("auto")) return std::nullopt;
  const std::optional<double> value =
      text.starts_with("auto:") ? ParseNumber(text.substr(5), low, high) : std::nullopt;
  if (!value) {
    ThrowUsage(fmt::format("{}={} needs a number from {} to {} after auto:", key, text, low, high));
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
