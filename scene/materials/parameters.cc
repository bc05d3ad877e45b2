#include "scene/materials/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "base/error.h"
#include "base/nearest_name.h"
#include "kernels/bsdf/bsdf.h"

namespace skywave {
namespace {

void Require(bool condition, std::string_view place, const std::string& reason) {
  if (!condition) throw InputError(InputPosition::File(std::string(place)), reason, kExitUsage);
}

// The values that a field may have. Fields without a line must not be negative.
struct Range {
  std::string_view field;
  float low, high;
};
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr Range kRanges[] = {
    {"reflectance", 0, 1},    {"second_color", 0, 1}, {"reflection", 0, 1},
    {"alpha", 0, 1},          {"alpha_across", 0, 1}, {"coat_alpha", 0, 1},
    {"sheen_alpha", 0, 1},    {"metallic", 0, 1},     {"coat", 0, 1},
    {"opacity", 0, 1},        {"coat_albedo", 0, 1},  {"coat_asymmetry", -1, 1},
    {"opacity_cutoff", 0, 1}, {"ior", 1e-3f, 1e3f},   {"normal_scale", -kLargest, kLargest}};

Range RangeOf(std::string_view field) {
  for (const Range& range : kRanges) {
    if (range.field == field) return range;
  }
  return {field, 0, kLargest};
}

// Each Assign puts `v`, which is not empty, into a field. It returns 0, or how many values the
// field takes if `v` has more or fewer.
using Values = std::span<const float>;
int Assign(Values v, float& field) { return v.size() == 1 ? (field = v[0], 0) : 1; }
int Assign(Values v, bool& field) { return v.size() == 1 ? (field = v[0] != 0, 0) : 1; }
// Fractions, and numbers beyond those that floats count exactly, name nothing.
std::uint32_t Index(float value) {
  return value <= 0x1p24f && value == std::floor(value) ? std::uint32_t(value) : ~0u;
}
int Assign(Values v, std::uint32_t& field) { return v.size() == 1 ? (field = Index(v[0]), 0) : 1; }
int Assign(Values v, glm::vec3& field) {
  if (v.size() == 1) return field = glm::vec3(v[0]), 0;
  return v.size() == 3 ? (field = {v[0], v[1], v[2]}, 0) : 3;
}
int Assign(Values v, Mixture& field) {
  if (v.size() != 3) return 3;
  Require(v[2] <= 1, "mixture", fmt::format("the share {} is not a number from 0 to 1", v[2]));
  field = {Index(v[0]), Index(v[1]), v[2]};
  return 0;
}
int Assign(Values, BsdfKind&) { return 0; }
template <class T>
int Assign(Values v, std::optional<T>& field) {
  T value = {};
  const int wanted = Assign(v, value);
  if (wanted == 0) field = value;
  return wanted;
}

// The field of each parameter of a material with these traits, by the name that users see.
struct NamedField {
  std::string_view name, field;
};
std::vector<NamedField> FieldsOf(const BsdfTraits& traits) {
  std::vector<NamedField> fields = {{"reflectance", "reflectance"}};
  for (const MaterialParameter& parameter : ParametersOf(traits)) {
    fields.push_back({parameter.name, parameter.field});
  }
  const Material material;
  Material::ForEachField(material, [&](std::string_view name, MaterialPart part, const auto&) {
    // These are parameters of BSDFs that list them.
    if (part == MaterialPart::kReflection || part == MaterialPart::kLayers ||
        part == MaterialPart::kReflectionLayers) {
      return;
    }
    if (part == MaterialPart::kLinks) return;  // bits that the options of links set
    const bool inside = part != MaterialPart::kAbsorption || traits.inside;
    const bool coat = part != MaterialPart::kCoatMedium || traits.tables.coat;
    const bool has_layers = traits.varying == Varying::kLayers;
    const bool layers = part != MaterialPart::kLayerTextures || has_layers;
    const bool of_glass =
        part != MaterialPart::kReflectionLayerTextures || has_layers || traits.glass_layers;
    if (part != MaterialPart::kBsdf && inside && coat && layers && of_glass) {
      fields.push_back({name, name});
    }
  });
  return fields;
}

}  // namespace

Material MakeMaterial(std::string_view bsdf) {
  std::vector<std::string_view> names;
  for (const BsdfKernels& kernels : Bsdfs()) names.push_back(kernels.name);
  const auto found = std::find(names.begin(), names.end(), bsdf);
  Require(
      found != names.end(), "bsdf",
      fmt::format("there is no '{}'; there are {}", bsdf, NearestFirst(bsdf, names, names.size())));
  Material material;
  material.bsdf = BsdfKind(found - names.begin());
  return material;
}

void SetParameter(const ParameterValues& parameter, Material& material) {
  const std::vector<NamedField> fields = FieldsOf(Bsdfs()[std::size_t(material.bsdf)]);
  std::vector<std::string_view> names;
  for (const NamedField& field : fields) names.push_back(field.name);
  const auto known = std::find(names.begin(), names.end(), parameter.name);
  Require(known != names.end(), parameter.name,
          fmt::format("the material has no such parameter; it has {}",
                      NearestFirst(parameter.name, names, names.size())));
  const std::string_view wanted = fields[std::size_t(known - names.begin())].field;
  const Range range = RangeOf(wanted);
  Require(!parameter.values.empty(), parameter.name, "has no value");
  for (const float value : parameter.values) {
    Require(value >= range.low && value <= range.high, parameter.name,
            fmt::format("{} is not a number from {:g} to {:g}", value, range.low, range.high));
  }
  Material::ForEachField(material, [&](std::string_view name, MaterialPart, auto& field) {
    if (name != wanted) return;
    const int count = Assign(parameter.values, field);
    Require(count == 0, parameter.name,
            fmt::format("takes {} values, not {}", count, parameter.values.size()));
  });
}

}  // namespace skywave
