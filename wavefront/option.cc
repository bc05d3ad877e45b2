#include "wavefront/option.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "base/error.h"

namespace skywave {
namespace {

template <class Number>
std::optional<Number> ParseNumber(const std::string& text, Number low, Number high) {
  Number value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  // A NaN is in no range.
  return value >= low && value <= high ? std::optional(value) : std::nullopt;
}

template <class Number>
Codec<Number> WholeNumberCodec(Number low, Number high) {
  return {.values = fmt::format("a whole number from {} to {}", low, high),
          .metavar = "N",
          .parse = [=](const std::string& text) { return ParseNumber(text, low, high); },
          .print = [](const Number& value) { return fmt::format("{}", value); }};
}

// Returns the values of an option that `text` holds: one, or those of a list.
std::vector<std::string> Values(const OptionInfo& option, const std::string& text) {
  if (option.most_values == 1) return {text};
  std::vector<std::string> values;
  std::string value;
  std::istringstream stream(text);
  if (option.delimiter != 0) {
    while (std::getline(stream, value, option.delimiter)) values.push_back(value);
  } else {
    while (stream >> value) values.push_back(value);
  }
  return values;
}

// `text` as one word of a shell command that spells bytes which no header, page or terminal may get
// as they are (POSIX.1-2024, 2.2.4).
std::string QuotedByCodes(const std::string& text) {
  std::string quoted = "$'";
  for (const char c : text) {
    const bool as_it_is = c >= ' ' && c <= '~' && c != '\'' && c != '\\';
    quoted += as_it_is ? std::string(1, c) : fmt::format("\\{:03o}", static_cast<unsigned char>(c));
  }
  return quoted + "'";
}

}  // namespace

Codec<std::uint64_t> WholeNumbers(std::uint64_t low, std::uint64_t high) {
  return WholeNumberCodec(low, high);
}

Codec<std::int64_t> SignedNumbers(std::int64_t low, std::int64_t high) {
  return WholeNumberCodec(low, high);
}

Codec<float> Floats(double low, double high) {
  return {.values = fmt::format("a number from {:g} to {:g}", low, high),
          .metavar = "X",
          .parse = [=](const std::string& text) -> std::optional<float> {
            const std::optional<float> value = ParseNumber(text, -std::numeric_limits<float>::max(),
                                                           std::numeric_limits<float>::max());
            // The bounds are rounded as the value is: 0.01 is in the range that begins with 0.01.
            return value && *value >= float(low) && *value <= float(high) ? value : std::nullopt;
          },
          .print = [](const float& value) { return fmt::format("{}", value); }};
}

Codec<double> Doubles(double low, double high) {
  return {.values = fmt::format("a number from {:g} to {:g}", low, high),
          .metavar = "X",
          .parse = [=](const std::string& text) { return ParseNumber(text, low, high); },
          .print = [](const double& value) { return fmt::format("{}", value); }};
}

Codec<std::string> Texts(const std::string& values) {
  return {.values = values,
          .metavar = values,
          .parse = [](const std::string& text) { return std::optional(text); },
          .print = [](const std::string& value) { return value; }};
}

std::vector<std::string> SplitWords(std::string_view words) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find('|', begin), words.size());
    parts.emplace_back(words.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

bool IsOneOf(std::string_view word, std::string_view words) {
  const std::vector<std::string> parts = SplitWords(words);
  return std::find(parts.begin(), parts.end(), word) != parts.end();
}

Codec<std::string> OneOf(const std::string& words) {
  Codec<std::string> codec = Texts(words);
  codec.parse = [words](const std::string& text) -> std::optional<std::string> {
    return IsOneOf(text, words) ? std::optional(text) : std::nullopt;
  };
  return codec;
}

Codec<bool> Switches() {
  return {.values = "true|false",
          .metavar = "",
          .parse = [](const std::string& text) -> std::optional<bool> {
            if (text == "true" || text == "1" || text == "on") return true;
            if (text == "false" || text == "0" || text == "off") return false;
            return std::nullopt;
          },
          .print = [](const bool& value) { return std::string(value ? "true" : "false"); },
          .is_switch = true};
}

std::string Joined(const OptionInfo& option, const std::vector<std::string>& texts) {
  const char separator = option.delimiter != 0 ? option.delimiter : ' ';
  return fmt::format("{}", fmt::join(texts, std::string(1, separator)));
}

std::string NotAValue(const std::string& text, const std::string& values) {
  return fmt::format("'{}' is not {}", text, values);
}

std::string Quoted(const std::string& text) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::strchr("_-+=:,./", c) != nullptr;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), plain)) return text;
  if (WithoutControlCodes(text) != text) return QuotedByCodes(text);
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string DefaultText(const OptionInfo& info) {
  if (info.is_switch || info.printed_default.empty()) return "";
  return (info.scene_may_set ? "the scene's, or " : "") + info.printed_default;
}

std::vector<std::string> IntegratorsOf(const OptionInfo& info) {
  std::vector<std::string> names;
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    if (info.applies == nullptr || info.applies(integrator)) {
      names.emplace_back(ToString(integrator));
    }
  }
  return names;
}

std::string Explanation(const OptionInfo& info) {
  std::string text(info.help);
  if (const std::string value = DefaultText(info); !value.empty()) {
    text += fmt::format(" (default: {})", value);
  }
  if (info.applies != nullptr) text += fmt::format(" [{}]", fmt::join(IntegratorsOf(info), ", "));
  return text;
}

void SetOption(std::span<const BoundOption> options, const std::string& name,
               const std::string& text) {
  std::vector<std::string_view> names;
  for (const BoundOption& option : options) {
    if (option.info.name != name) {
      names.push_back(option.info.name);
      continue;
    }
    const std::vector<std::string> values = Values(option.info, text);
    const std::string problem = values.empty() ? "needs a value" : option.set(values);
    if (!problem.empty()) throw OptionError(name, "", problem);
    return;
  }
  const std::string nearest = NearestName(name, names);
  throw OptionError(name, "",
                    "there is no such option" +
                        (nearest.empty() ? std::string() : "; did you mean `" + nearest + "`?"));
}

void SetOptions(std::span<const BoundOption> options,
                const std::vector<std::pair<std::string, std::string>>& values) {
  for (const auto& [name, text] : values) SetOption(options, name, text);
  const auto given = [&](std::string_view name) {
    return std::any_of(values.begin(), values.end(),
                       [&](const auto& value) { return value.first == name; });
  };
  for (const BoundOption& option : options) {
    const OptionInfo& info = option.info;
    if (!given(info.name)) continue;
    if (!info.needs.empty() && !given(info.needs)) {
      throw OptionError(std::string(info.name), "", fmt::format("needs `{}` too", info.needs));
    }
    if (!info.excludes.empty() && given(info.excludes)) {
      throw OptionError(std::string(info.name), "",
                        fmt::format("does not go together with `{}`", info.excludes));
    }
  }
}

}  // namespace skywave
