#include "scene/pbrt/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>

#include "base/files.h"
#include "scene/materials/spectrum.h"

namespace skywave {
namespace {

enum class ValueKind { kFloat, kInteger, kString, kBool, kFloatOrString };

struct TypeInfo {
  std::string_view name;
  ValueKind kind;
  std::size_t group;  // values come in multiples of this
};

constexpr TypeInfo kTypes[] = {
    {"float", ValueKind::kFloat, 1},     {"integer", ValueKind::kInteger, 1},
    {"bool", ValueKind::kBool, 1},       {"string", ValueKind::kString, 1},
    {"texture", ValueKind::kString, 1},  {"rgb", ValueKind::kFloat, 3},
    {"color", ValueKind::kFloat, 3},     {"xyz", ValueKind::kFloat, 3},
    {"point", ValueKind::kFloat, 3},     {"point3", ValueKind::kFloat, 3},
    {"point2", ValueKind::kFloat, 2},    {"vector", ValueKind::kFloat, 3},
    {"vector3", ValueKind::kFloat, 3},   {"vector2", ValueKind::kFloat, 2},
    {"normal", ValueKind::kFloat, 3},    {"normal3", ValueKind::kFloat, 3},
    {"blackbody", ValueKind::kFloat, 1}, {"spectrum", ValueKind::kFloatOrString, 1},
};

const TypeInfo* FindType(std::string_view name) {
  const auto* found =
      std::find_if(std::begin(kTypes), std::end(kTypes), [&](auto& t) { return t.name == name; });
  return found == std::end(kTypes) ? nullptr : found;
}

std::int32_t ParseInteger(const PbrtSource& source, const PbrtToken& token) {
  std::int32_t value = 0;
  const char* end = token.text.data() + token.text.size();
  const auto [stop, error] = std::from_chars(token.text.data(), end, value);
  if (error == std::errc() && stop == end) return value;
  // Some exporters write whole numbers with a fraction.
  const double number = ParseNumber(source, token);
  if (number != std::floor(number) || std::abs(number) > std::numeric_limits<std::int32_t>::max()) {
    throw InputError(PositionOf(source, token), "an integer is expected, not " + Describe(token));
  }
  return static_cast<std::int32_t>(number);
}

void AddValue(const PbrtSource& source, const PbrtToken& token, ValueKind kind,
              PbrtParameter& parameter) {
  const bool is_string = token.kind == PbrtTokenKind::kString;
  if (kind == ValueKind::kFloatOrString) kind = is_string ? ValueKind::kString : ValueKind::kFloat;
  switch (kind) {
    case ValueKind::kFloat:
      parameter.floats.push_back(static_cast<float>(ParseNumber(source, token)));
      return;
    case ValueKind::kInteger:
      if (is_string) {
        throw InputError(PositionOf(source, token),
                         "an integer is expected, not " + Describe(token));
      }
      parameter.ints.push_back(ParseInteger(source, token));
      return;
    case ValueKind::kBool:  // quoted in pbrt-v3, bare in pbrt-v4
      if (token.text != "true" && token.text != "false") {
        throw InputError(PositionOf(source, token),
                         "true or false is expected, not " + Describe(token));
      }
      parameter.strings.emplace_back(token.text);
      return;
    default:
      if (!is_string) {
        throw InputError(PositionOf(source, token),
                         "a string in quotes is expected, not " + Describe(token));
      }
      parameter.strings.push_back(Unescape(source, token));
  }
}

// Splits a declaration "type name".
PbrtParameter Declare(const PbrtSource& source, const PbrtToken& token) {
  constexpr std::string_view kSpace = " \t";
  const std::string_view text = token.text;
  const std::size_t type_begin = std::min(text.find_first_not_of(kSpace), text.size());
  const std::size_t type_end = std::min(text.find_first_of(kSpace, type_begin), text.size());
  const std::size_t name_begin = std::min(text.find_first_not_of(kSpace, type_end), text.size());
  const std::size_t name_end = std::min(text.find_first_of(kSpace, name_begin), text.size());
  if (name_begin == name_end ||
      text.find_first_not_of(kSpace, name_end) != std::string_view::npos) {
    throw InputError(PositionOf(source, token),
                     fmt::format("a parameter \"type name\" is expected, not {}", Describe(token)));
  }
  PbrtParameter parameter;
  parameter.type = text.substr(type_begin, type_end - type_begin);
  parameter.name = text.substr(name_begin, name_end - name_begin);
  parameter.position = PositionOf(source, token);
  return parameter;
}

// Replaces a spectrum given by a file with its pairs. Other names stay because they may be known
// ones.
void LoadSpectrumFile(const PbrtSource& source, PbrtParameter& parameter) {
  if (parameter.type != "spectrum" || parameter.strings.size() != 1) return;
  const std::string path = FindPbrtFile(source, parameter.strings[0]);
  std::error_code ignored;
  if (path.empty() || !std::filesystem::is_regular_file(path, ignored)) return;
  for (const glm::vec2& pair : ParseSpectrumFile(ReadFile(path), path)) {
    parameter.floats.push_back(pair.x);
    parameter.floats.push_back(pair.y);
  }
  parameter.strings.clear();
}

PbrtParameter ReadParameter(PbrtSource& source) {
  const PbrtToken declaration = NextToken(source);
  PbrtParameter parameter = Declare(source, declaration);
  const TypeInfo* type = FindType(parameter.type);
  if (!type) {
    throw InputError(
        parameter.position,
        fmt::format("\"{}\" is not a parameter type; the types are {}", parameter.type, [] {
          std::string names;
          for (const TypeInfo& t : kTypes) {
            names += names.empty() ? "" : ", ";
            names += t.name;
          }
          return names;
        }()));
  }
  PbrtToken token = NextToken(source);
  if (token.kind == PbrtTokenKind::kOpen) {
    for (token = NextToken(source); token.kind != PbrtTokenKind::kClose;
         token = NextToken(source)) {
      if (token.kind == PbrtTokenKind::kEnd || token.kind == PbrtTokenKind::kOpen) {
        throw InputError(
            PositionOf(source, token),
            fmt::format("']' of \"{} {}\" (line {}) is expected, not {}", parameter.type,
                        parameter.name, declaration.line, Describe(token)));
      }
      AddValue(source, token, type->kind, parameter);
    }
  } else {
    AddValue(source, token, type->kind, parameter);
  }
  LoadSpectrumFile(source, parameter);
  if (parameter.floats.size() % type->group != 0) {
    throw InputError(parameter.position,
                     fmt::format("\"{} {}\" has {} values: not a multiple of {}", parameter.type,
                                 parameter.name, parameter.floats.size(), type->group));
  }
  return parameter;
}

template <typename Value>
const Value& Single(const PbrtParameter& parameter, const std::vector<Value>& values) {
  if (values.size() != 1) {
    throw InputError(parameter.position,
                     fmt::format("\"{} {}\" takes one value, not {}", parameter.type,
                                 parameter.name, values.size()));
  }
  return values[0];
}

glm::vec3 ColorOfBlackbody(const PbrtParameter& parameter) {
  // pbrt-v4 gives the temperature; pbrt-v3 gives temperature and scale.
  const std::vector<float>& values = parameter.floats;
  if (values.empty() || values.size() > 2 || !(values[0] > 0)) {
    throw InputError(parameter.position,
                     fmt::format("\"blackbody {}\" takes a temperature above 0 and maybe a scale",
                                 parameter.name));
  }
  return values.size() == 1 ? RgbOfBlackbody(values[0]) : values[1] * RgbOfBlackbodyPeak(values[0]);
}

glm::vec3 ColorOfPairs(const PbrtParameter& parameter, SpectrumUse use) {
  const std::vector<glm::vec2> pairs = PairsOf(parameter);
  switch (use) {
    case SpectrumUse::kReflectance:
      return RgbOfReflectance(pairs);
    case SpectrumUse::kEmission:
      return RgbOfEmission(pairs);
    case SpectrumUse::kUnitEmission:
      return RgbOfUnitEmission(pairs);
  }
  return glm::vec3(0);
}

}  // namespace

std::vector<glm::vec2> PairsOf(const PbrtParameter& parameter) {
  const std::vector<float>& values = parameter.floats;
  std::vector<glm::vec2> pairs;
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
    pairs.emplace_back(values[i], values[i + 1]);
  }
  const auto descent =
      std::adjacent_find(pairs.begin(), pairs.end(), [](auto& a, auto& b) { return !(a.x < b.x); });
  if (values.empty() || values.size() % 2 != 0 || descent != pairs.end()) {
    throw InputError(parameter.position,
                     fmt::format("\"spectrum {}\" takes pairs of wavelength and value, wavelengths "
                                 "ascending",
                                 parameter.name));
  }
  return pairs;
}

PbrtParameters ReadParameters(PbrtSource& source, const InputPosition& position,
                              const std::string& directive, Warnings& warnings) {
  PbrtParameters parameters{position, directive, {}};
  for (PbrtSource* from = &source;;) {
    const PbrtTokenKind next = PeekToken(*from).kind;
    if (next == PbrtTokenKind::kEnd && from->includer != nullptr) {
      from = from->includer;  // parameters may go on after the Include
      continue;
    }
    if (next != PbrtTokenKind::kString) break;
    PbrtParameter parameter = ReadParameter(*from);
    const auto earlier = std::find_if(
        parameters.list.begin(), parameters.list.end(), [&](const PbrtParameter& other) {
          return other.name == parameter.name && other.type == parameter.type;
        });
    if (earlier != parameters.list.end()) {
      AddWarning(warnings, parameter.position,
                 fmt::format("{}: \"{} {}\" is given twice: the last one counts", directive,
                             parameter.type, parameter.name));
      *earlier = std::move(parameter);
      continue;
    }
    if (parameters.list.size() == kMaxPbrtParameters) {
      throw InputError(parameter.position, fmt::format("{} has more than {} parameters", directive,
                                                       kMaxPbrtParameters));
    }
    parameters.list.push_back(std::move(parameter));
  }
  return parameters;
}

PbrtParameter* Find(PbrtParameters& parameters, std::initializer_list<std::string_view> types,
                    std::string_view name) {
  for (PbrtParameter& parameter : parameters.list) {
    if (parameter.name == name &&
        std::find(types.begin(), types.end(), parameter.type) != types.end()) {
      parameter.used = true;
      return &parameter;
    }
  }
  return nullptr;
}

std::optional<float> FindFloat(PbrtParameters& parameters, std::string_view name) {
  const PbrtParameter* found = Find(parameters, {"float"}, name);
  if (!found) return std::nullopt;
  return Single(*found, found->floats);
}

std::optional<int> FindInt(PbrtParameters& parameters, std::string_view name) {
  const PbrtParameter* found = Find(parameters, {"integer"}, name);
  if (!found) return std::nullopt;
  return Single(*found, found->ints);
}

std::optional<bool> FindBool(PbrtParameters& parameters, std::string_view name) {
  const PbrtParameter* found = Find(parameters, {"bool"}, name);
  if (!found) return std::nullopt;
  return Single(*found, found->strings) == "true";
}

std::optional<std::string> FindString(PbrtParameters& parameters, std::string_view name) {
  const PbrtParameter* found = Find(parameters, {"string"}, name);
  if (!found) return std::nullopt;
  return Single(*found, found->strings);
}

std::optional<glm::vec3> FindColor(PbrtParameters& parameters, std::string_view name,
                                   const PbrtTextures& textures, Warnings& warnings,
                                   SpectrumUse use) {
  const PbrtParameter* found =
      Find(parameters, {"rgb", "color", "xyz", "float", "texture", "spectrum", "blackbody"}, name);
  if (!found) return std::nullopt;
  const auto not_simple = [&](const std::string& reason) {
    AddWarning(warnings, found->position,
               fmt::format("{}: \"{} {}\" {}: the default is used", parameters.directive,
                           found->type, found->name, reason));
    return std::nullopt;
  };
  if (found->type == "blackbody") return ColorOfBlackbody(*found);
  if (found->type == "texture") {
    const auto texture = textures.find(Single(*found, found->strings));
    if (texture == textures.end()) {
      return not_simple(fmt::format("names no texture that is there (\"{}\")", found->strings[0]));
    }
    const PbrtTexture& named = texture->second;
    // One that was left out has its own warning.
    if (!named.value && !named.image && !named.solid) return std::nullopt;
    if (!named.value || named.image) {
      return not_simple(fmt::format("(\"{}\") varies", found->strings[0]));
    }
    return named.value;
  }
  if (found->type == "float") return glm::vec3(Single(*found, found->floats));
  if (found->type == "spectrum") {
    if (found->strings.empty()) return ColorOfPairs(*found, use);
    const std::string& spectrum = Single(*found, found->strings);
    if (const auto illuminant = RgbOfIlluminant(spectrum)) return illuminant;
    return not_simple(fmt::format("(\"{}\") is neither a file nor a name that is known", spectrum));
  }
  if (found->floats.size() != 3) {
    throw InputError(found->position, fmt::format("\"{} {}\" takes three values, not {}",
                                                  found->type, name, found->floats.size()));
  }
  const glm::vec3 color(found->floats[0], found->floats[1], found->floats[2]);
  if (found->type == "xyz") return RgbFromXyz(color);
  if (!parameters.color_space) return color;
  const auto& [light, reflectance] = *parameters.color_space;
  const glm::vec3 rgb = (use == SpectrumUse::kReflectance ? reflectance : light) * color;
  constexpr float kRounding = 1e-5f;
  const float least = std::min({rgb.x, rgb.y, rgb.z}), most = std::max({rgb.x, rgb.y, rgb.z});
  if (least < -kRounding * std::max(most, 1.0f)) {
    AddWarning(warnings, found->position,
               fmt::format("{}: \"{} {}\" is outside of Rec. 709: clamped at 0",
                           parameters.directive, found->type, found->name));
  }
  return glm::max(rgb, glm::vec3(0));
}

std::optional<PbrtTexture> FindImageTexture(PbrtParameters& parameters, std::string_view name,
                                            const PbrtTextures& textures) {
  const PbrtParameter* found = Find(parameters, {"texture"}, name);
  if (!found) return std::nullopt;
  const auto texture = textures.find(Single(*found, found->strings));
  if (texture == textures.end() || !texture->second.image) return std::nullopt;
  return texture->second;
}

std::optional<PbrtTexture> FindSolidTexture(PbrtParameters& parameters, std::string_view name,
                                            const PbrtTextures& textures) {
  const PbrtParameter* found = Find(parameters, {"texture"}, name);
  if (!found) return std::nullopt;
  const auto texture = textures.find(Single(*found, found->strings));
  if (texture == textures.end() || !texture->second.solid) return std::nullopt;
  return texture->second;
}

void UseAll(PbrtParameters& parameters) {
  for (PbrtParameter& parameter : parameters.list) parameter.used = true;
}

void ReportUnused(const PbrtParameters& parameters, Warnings& warnings) {
  for (const PbrtParameter& parameter : parameters.list) {
    if (parameter.used) continue;
    AddWarning(warnings, parameter.position,
               fmt::format("{}: \"{} {}\" is not understood: ignored", parameters.directive,
                           parameter.type, parameter.name));
  }
}

}  // namespace skywave
