#include "lights/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

#include "base/error.h"

namespace skywave {
namespace {

[[noreturn]] void ThrowUsage(const std::string& reason) {
  throw OptionError("strategy", "", reason);
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

const std::string& TextValue(const StrategyValues& values, std::string_view key) {
  return std::find_if(values.begin(), values.end(),
                      [&](const auto& value) { return value.first == key; })
      ->second;
}

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
