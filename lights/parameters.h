// The parameters that strategies and makers of lights take, as text of the form
// "name:key=value,key=value".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skywave {

// What a strategy is used for, where defaults depend on it.
struct StrategyUse {
  bool mis = false;  // BSDF samples share the work
  std::uint32_t light_samples = 1;
  bool starts_light_paths = false;
};

// A parameter of a strategy as the user gives it: --strategy name:key=value,key=value.
struct StrategyParameter {
  std::string_view key, default_value, meaning;
  // Returns the default for a use; null: it is default_value whatever the use.
  std::string (*default_for)(const StrategyUse& use) = nullptr;
  bool chooses_lights = false;  // has no say where a file brings them
};
using StrategyValues = std::vector<std::pair<std::string, std::string>>;

// Returns the value of `key`, which the factory declares: given or default. Throws InputError for a
// text that is no such value or out of range.
bool BoolValue(const StrategyValues& values, std::string_view key);
int IntValue(const StrategyValues& values, std::string_view key, int low, int high);
double NumberValue(const StrategyValues& values, std::string_view key, double low, double high);
// Returns the number in "auto:NUMBER", or nothing for a text that does not begin with auto.
std::optional<double> AutoValue(const StrategyValues& values, std::string_view key, double low,
                                double high);
const std::string& TextValue(const StrategyValues& values, std::string_view key);
std::size_t ChoiceValue(const StrategyValues& values, std::string_view key,
                        std::span<const std::string_view> choices);

}  // namespace skywave
