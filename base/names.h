// Names of the values of an enum, as used in options, files and reports. A header specialises
// kEnumNames for an enum; reading, writing and listing its names follow from that table.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace skywave {

template <class Enum>
struct Named {
  Enum value;
  std::string_view name;
};

// Specialisations are arrays of Named<Enum>, in the order in which help texts list the names.
template <class Enum>
inline constexpr std::array<Named<Enum>, 0> kEnumNames = {};

template <class Enum>
concept HasNames = std::is_enum_v<Enum> &&(kEnumNames<Enum>.size() > 0);

template <HasNames Enum>
constexpr std::string_view ToString(Enum value) {
  for (const Named<Enum>& row : kEnumNames<Enum>) {
    if (row.value == value) return row.name;
  }
  return "";
}

template <HasNames Enum>
constexpr std::optional<Enum> Parse(std::string_view name) {
  for (const Named<Enum>& row : kEnumNames<Enum>) {
    if (row.name == name) return row.value;
  }
  return std::nullopt;
}

template <HasNames Enum>
constexpr auto ValuesOf() {
  std::array<Enum, kEnumNames<Enum>.size()> values;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = kEnumNames<Enum>[i].value;
  return values;
}
template <HasNames Enum>
constexpr auto NamesOf() {
  std::array<std::string_view, kEnumNames<Enum>.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kEnumNames<Enum>[i].name;
  return names;
}

// Returns "box|triangle|gaussian", the form of usage texts.
template <HasNames Enum>
std::string Choices() {
  std::string text;
  for (const Named<Enum>& row : kEnumNames<Enum>) {
    if (!text.empty()) text += '|';
    text += row.name;
  }
  return text;
}

}  // namespace skywave
