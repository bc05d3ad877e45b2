#include "cli/flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

namespace skywave {

CLI::Validator FiniteNumber(double low, double high) {
  return CLI::Validator(
      [low, high](const std::string& text) {
        double value = 0;
        const bool is_number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
        return is_number && value >= low && value <= high
                   ? std::string()
                   : fmt::format("'{}' is no number from {:g} to {:g}", text, low, high);
      },
      fmt::format("FLOAT in [{:g} - {:g}]", low, high));
}

std::string Quoted(const std::string& text) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::strchr("_-+=:,./", c) != nullptr;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), plain)) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string SpellFlags(std::string_view text) {
  std::string spelled;
  bool mention = false;
  for (const char c : text) {
    if (c != '`') {
      spelled += c;
    } else if (mention = !mention; mention) {
      spelled += "--";
    }
  }
  return spelled;
}

std::string Message(const OptionError& error) {
  std::string flags;
  for (const OptionValue& option : error.options()) {
    if (!flags.empty()) flags += ' ';
    flags += "--" + option.name;
    if (!option.value.empty()) flags += ' ' + option.value;
  }
  return flags + ": " + SpellFlags(error.why());
}

}  // namespace skywave
