#include "job/material_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "base/error.h"
#include "base/nearest_name.h"
#include "scene/geometry_checks.h"
#include "scene/materials/parameters.h"

namespace skywave {
namespace {

// A change as its text says it.
struct MaterialChange {
  std::string name, bsdf;  // no BSDF: the material's own
  std::vector<ParameterValues> parameters;
};

// Returns `text` without the blanks around it.
std::string_view Trimmed(std::string_view text) {
  const std::size_t first = std::min(text.find_first_not_of(' '), text.size());
  text.remove_prefix(first);
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(separator, from), text.size());
    parts.emplace_back(Trimmed(text.substr(from, to - from)));
    from = to + 1;
  }
  return parts;
}

// Reads "KEY=1" and "KEY=0.8/0.2/0.1".
ParameterValues ReadParameter(const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos) {
    throw InputError({}, fmt::format("'{}' is not KEY=VALUE", text), kExitUsage);
  }
  ParameterValues parameter = {.name = text.substr(0, sign), .values = {}};
  for (const std::string& word : Split(std::string_view(text).substr(sign + 1), '/')) {
    float value = 0;
    const char* const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (error != std::errc() || stop != end) {
      throw InputError({}, fmt::format("{}: '{}' is not a number", parameter.name, word),
                       kExitUsage);
    }
    parameter.values.push_back(value);
  }
  return parameter;
}

// The name of a material may hold the sign that ends it: the longest name of the scene counts, and
// without any, everything before the first sign.
std::size_t LengthOfName(const std::string& text, const std::vector<std::string_view>& names) {
  std::size_t length = std::string::npos;
  for (const std::string_view name : names) {
    const bool begins =
        text.starts_with(name) && text.size() > name.size() && text[name.size()] == '=';
    if (begins && (length == std::string::npos || name.size() > length)) length = name.size();
  }
  return length != std::string::npos ? length : text.find('=');
}

MaterialChange ReadChange(const std::string& text, const std::vector<std::string_view>& names) {
  const std::size_t length = LengthOfName(text, names);
  if (length == std::string::npos) {
    throw InputError({}, "is not NAME=BSDF[:KEY=VALUE,...]", kExitUsage);
  }
  MaterialChange change = {.name = text.substr(0, length), .bsdf = {}, .parameters = {}};
  const std::string_view rest = std::string_view(text).substr(length + 1);
  const std::size_t colon = std::min(rest.find(':'), rest.size());
  change.bsdf = rest.substr(0, colon);
  if (colon == rest.size()) {
    if (rest.empty()) throw InputError({}, "names no BSDF and no parameter", kExitUsage);
    return change;
  }
  for (const std::string& parameter : Split(rest.substr(colon + 1), ',')) {
    change.parameters.push_back(ReadParameter(parameter));
  }
  return change;
}

void ChangeMaterial(const MaterialChange& change, Material& material) {
  if (!change.bsdf.empty()) {
    std::string name = std::move(material.name);
    material = MakeMaterial(change.bsdf);
    material.name = std::move(name);
  } else if (material.mixture) {
    throw InputError({}, "is a mixture: change the materials that it mixes, or give it a BSDF",
                     kExitUsage);
  }
  for (const ParameterValues& parameter : change.parameters) SetParameter(parameter, material);
}

void ChangeAll(const std::string& text, Scene& scene) {
  std::vector<std::string_view> names;
  for (const Material& material : scene.materials) names.push_back(material.name);
  const MaterialChange change = ReadChange(std::string(Trimmed(text)), names);
  bool found = false;
  for (Material& material : scene.materials) {
    if (material.name != change.name) continue;
    ChangeMaterial(change, material);
    found = true;
  }
  if (!found) {
    throw InputError({},
                     fmt::format("the scene has no material '{}'; it has {}", change.name,
                                 NearestFirst(change.name, names)),
                     kExitUsage);
  }
  CheckMaterials(scene, "");
}

}  // namespace

void ChangeMaterials(const std::vector<std::string>& changes, Scene& scene) {
  for (const std::string& change : changes) {
    try {
      ChangeAll(change, scene);
    } catch (const InputError& error) {
      throw OptionError("material", change, error.what());
    }
  }
}

void LeaveOutCompensation(Scene& scene) {
  for (Material& material : scene.materials) {
    material.energy_compensation = false;
    // An image of one width need not have it in the channel of the width across.
    if (material.bsdf != BsdfKind::kConductor || material.roughness_texture) continue;
    // With equal widths the anisotropic one has the same facets, and draws no lobe but theirs.
    material.bsdf = BsdfKind::kAnisotropicConductor;
    material.alpha_across = material.alpha;
  }
}

}  // namespace skywave
