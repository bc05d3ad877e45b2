#include "scene/pbrt_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "scene/metals.h"

namespace skywave {
namespace {

struct Context {
  PbrtParameters& parameters;
  const PbrtTextures& textures;
  Warnings& warnings;
};

// A colour that is a fraction of light: clamped to [0, 1], with a warning where that changes it.
std::optional<glm::vec3> FindFraction(Context& context, std::string_view name) {
  const auto color = FindColor(context.parameters, name, context.textures, context.warnings);
  if (!color) return std::nullopt;
  const glm::vec3 clamped = glm::clamp(*color, 0.0f, 1.0f);
  if (clamped != *color) {
    AddWarning(context.warnings, context.parameters.position,
               fmt::format("{}: \"{}\" is clamped to [0, 1]", context.parameters.directive, name));
  }
  return clamped;
}

// The first that is given of a v4 and a v3 name.
glm::vec3 FractionOr(Context& context, std::initializer_list<std::string_view> names,
                     const glm::vec3& fallback) {
  for (const std::string_view name : names) {
    if (const auto color = FindFraction(context, name)) return *color;
  }
  return fallback;
}

// A float, or a texture of one value.
std::optional<float> FindScalar(Context& context, std::string_view name) {
  const auto color = FindColor(context.parameters, name, context.textures, context.warnings);
  if (!color) return std::nullopt;
  return color->x;
}

// The reflectance of a diffuse surface, with its image if it has one.
void SetReflectance(Context& context, float fallback, Material& material) {
  for (const std::string_view name : {"reflectance", "Kd"}) {
    const auto texture = FindImageTexture(context.parameters, name, context.textures);
    if (!texture) continue;
    material.reflectance = glm::max(texture->value.value_or(glm::vec3(1)), glm::vec3(0));
    material.color_texture = texture->image;
    return;
  }
  material.reflectance = FractionOr(context, {"reflectance", "Kd"}, glm::vec3(fallback));
}

Material Lambert(Context& context) {
  Material material;
  SetReflectance(context, 0.5f, material);
  return material;
}

Material Matte(Context& context) {
  Material material = Lambert(context);
  if (FindScalar(context, "sigma").value_or(0) != 0) {
    AddWarning(context.warnings, context.parameters.position,
               fmt::format("{}: \"sigma\" (Oren-Nayar) is not supported: rendered as Lambert",
                           context.parameters.directive));
  }
  return material;
}

Material LambertInstead(Context& context) {
  AddWarning(context.warnings, context.parameters.position,
             fmt::format("{} is not supported: rendered as Lambert of its diffuse colour",
                         context.parameters.directive));
  return Lambert(context);
}

Material Mirror(Context& context) {
  Material material;
  material.bsdf = BsdfKind::kMirror;
  material.reflectance = FractionOr(context, {"Kr"}, glm::vec3(0.9f));
  return material;
}

// The metal of "metal-Cu-eta" (v4) or "spds/Cu.eta.spd" (v3), if it is one that is known.
std::optional<MetalIndex> MetalOfSpectrumName(std::string_view name, std::string_view part) {
  constexpr std::string_view kPrefix = "metal-";
  const std::string v4_ending = "-" + std::string(part),
                    v3_ending = "." + std::string(part) + ".spd";
  if (name.starts_with(kPrefix) && name.ends_with(v4_ending) &&
      name.size() > kPrefix.size() + v4_ending.size()) {
    return FindMetal(name.substr(kPrefix.size(), name.size() - kPrefix.size() - v4_ending.size()));
  }
  if (name.ends_with(v3_ending)) {
    name.remove_suffix(v3_ending.size());
    const std::size_t slash = name.find_last_of('/');
    return FindMetal(slash == std::string_view::npos ? name : name.substr(slash + 1));
  }
  return std::nullopt;
}

// `part` is "eta" or "k".
glm::vec3 ConductorIndex(Context& context, std::string_view part, const MetalIndex& fallback) {
  const auto pick = [&](const MetalIndex& metal) { return part == "eta" ? metal.eta : metal.k; };
  if (const PbrtParameter* named = Find(context.parameters, {"spectrum"}, part);
      named && named->strings.size() == 1) {
    if (const auto metal = MetalOfSpectrumName(named->strings[0], part)) return pick(*metal);
  }
  const auto color = FindColor(context.parameters, part, context.textures, context.warnings);
  if (color && !glm::all(glm::greaterThanEqual(*color, glm::vec3(0)))) {
    throw InputError(context.parameters.position,
                     fmt::format("{}: \"{}\" is negative", context.parameters.directive, part));
  }
  return color.value_or(pick(fallback));
}

// pbrt's roughness as a GGX width. pbrt-v3 remaps by a polynomial in log(roughness), pbrt-v4 by a
// square root.
float AlphaFromRoughness(float roughness, bool remap, bool v4) {
  if (!remap) return roughness;
  if (v4) return std::sqrt(roughness);
  const float x = std::log(std::max(roughness, 1e-3f));
  return 1.62142f + x * (0.819955f + x * (0.1734f + x * (0.0171201f + x * 0.000640711f)));
}

Material Conductor(Context& context, bool v4) {
  PbrtParameters& parameters = context.parameters;
  Material material;
  material.bsdf = BsdfKind::kConductor;
  material.reflectance = glm::vec3(1);
  if (const auto reflectance = FindFraction(context, "reflectance")) {
    const MetalIndex index = MetalOfReflectance(*reflectance);
    material.eta = index.eta;
    material.k = index.k;
  } else {
    const MetalIndex copper = *FindMetal("Cu");
    material.eta = ConductorIndex(context, "eta", copper);
    material.k = ConductorIndex(context, "k", copper);
  }

  const float roughness = FindScalar(context, "roughness").value_or(v4 ? 0.0f : 0.01f);
  const float u = FindScalar(context, "uroughness").value_or(roughness);
  const float v = FindScalar(context, "vroughness").value_or(roughness);
  if (!(u >= 0 && v >= 0)) {
    throw InputError(parameters.position, parameters.directive + ": roughness is negative");
  }
  const bool remap = FindBool(parameters, "remaproughness").value_or(true);
  const float alpha_u = AlphaFromRoughness(u, remap, v4),
              alpha_v = AlphaFromRoughness(v, remap, v4);
  material.alpha = std::sqrt(alpha_u * alpha_v);
  if (u != v) {
    AddWarning(
        context.warnings, parameters.position,
        fmt::format("{}: anisotropic roughness is not supported: rendered with the geometric "
                    "mean, alpha {:.3g}",
                    parameters.directive, material.alpha));
  }
  // pbrt's own threshold between rough and specular.
  if (material.alpha < 1e-3f) material.bsdf = BsdfKind::kMirror;
  return material;
}

// A diffuse body under a dielectric coat. pbrt's four differ in how the coat is weighted and what
// it lets through; here it is that of an index.
Material Coated(Context& context, bool v4) {
  PbrtParameters& parameters = context.parameters;
  Material material;
  material.bsdf = BsdfKind::kMetallicRoughness;
  SetReflectance(context, v4 ? 0.5f : 0.25f, material);
  const float roughness = FindScalar(context, "roughness").value_or(v4 ? 0.0f : 0.1f);
  const float u = FindScalar(context, "uroughness").value_or(roughness);
  const float v = FindScalar(context, "vroughness").value_or(roughness);
  if (!(u >= 0 && v >= 0)) {
    throw InputError(parameters.position, parameters.directive + ": roughness is negative");
  }
  const bool remap = FindBool(parameters, "remaproughness").value_or(true);
  material.alpha = std::sqrt(AlphaFromRoughness(u, remap, v4) * AlphaFromRoughness(v, remap, v4));
  for (const std::string_view name : {"eta", "index"}) {
    material.ior = FindScalar(context, name).value_or(material.ior);
  }
  if (!(material.ior > 0)) {
    throw InputError(parameters.position, fmt::format("{}: the index of refraction is {}",
                                                      parameters.directive, material.ior));
  }
  FindFraction(context, "Ks");
  AddWarning(context.warnings, parameters.position,
             fmt::format("{} is approximated by a diffuse body under a coat of index {:.4g}",
                         parameters.directive, material.ior));
  return material;
}

struct NamedGlass {
  std::string_view name;
  float ior;  // at the sodium D line, 589 nm
};
// Schott's catalogue; the names are pbrt-v4's.
constexpr std::array kGlasses = {
    NamedGlass{"glass-BK7", 1.5168f},   NamedGlass{"glass-BAF10", 1.6700f},
    NamedGlass{"glass-FK51A", 1.4866f}, NamedGlass{"glass-LASF9", 1.8503f},
    NamedGlass{"glass-F5", 1.6034f},    NamedGlass{"glass-F10", 1.6228f},
    NamedGlass{"glass-SF10", 1.7283f},  NamedGlass{"glass-SF11", 1.7847f},
};

Material Dielectric(Context& context) {
  PbrtParameters& parameters = context.parameters;
  Material material;
  material.bsdf = BsdfKind::kDielectric;
  material.reflectance = glm::vec3(1);
  for (const std::string_view name : {"eta", "index"}) {
    const PbrtParameter* named = Find(parameters, {"spectrum"}, name);
    const auto* glass = named && named->strings.size() == 1
                            ? std::find_if(kGlasses.begin(), kGlasses.end(),
                                           [&](auto& g) { return g.name == named->strings[0]; })
                            : kGlasses.end();
    if (glass != kGlasses.end()) {
      material.ior = glass->ior;
    } else if (const auto ior = FindScalar(context, name)) {
      material.ior = *ior;
    }
  }
  if (!(material.ior > 0)) {
    throw InputError(parameters.position, fmt::format("{}: the index of refraction is {}",
                                                      parameters.directive, material.ior));
  }
  float roughness = 0;
  for (const std::string_view name : {"roughness", "uroughness", "vroughness"}) {
    roughness = std::max(roughness, FindScalar(context, name).value_or(0));
  }
  FindBool(parameters, "remaproughness");
  if (roughness > 0) {
    AddWarning(context.warnings, parameters.position,
               parameters.directive + ": roughness is not supported: rendered smooth");
  }
  const glm::vec3 reflect = FractionOr(context, {"Kr"}, glm::vec3(1));
  const glm::vec3 transmit = FractionOr(context, {"Kt"}, glm::vec3(1));
  if (reflect != glm::vec3(1) || transmit != glm::vec3(1)) {
    AddWarning(context.warnings, parameters.position,
               parameters.directive + ": \"Kr\" and \"Kt\" are not supported: rendered with 1");
  }
  return material;
}

Material ByType(const std::string& type, Context& context) {
  if (type == "diffuse") return Lambert(context);
  if (type == "matte") return Matte(context);
  if (type == "mirror") return Mirror(context);
  if (type == "metal") return Conductor(context, false);
  if (type == "conductor") return Conductor(context, true);
  if (type == "glass" || type == "dielectric") return Dielectric(context);
  if (type == "coateddiffuse") return Coated(context, true);
  if (type == "plastic" || type == "substrate" || type == "uber") return Coated(context, false);
  for (const char* other : {"translucent", "shinymetal", "disney", "diffusetransmission"}) {
    if (type == other) return LambertInstead(context);
  }
  AddWarning(context.warnings, context.parameters.position,
             context.parameters.directive + " is not supported: rendered as grey Lambert");
  return Material{};
}

}  // namespace

Material MakePbrtMaterial(const std::string& type, PbrtParameters& parameters,
                          const PbrtTextures& textures, Warnings& warnings) {
  Context context{parameters, textures, warnings};
  Material material = ByType(type, context);
  ReportUnused(parameters, warnings);
  return material;
}

bool IsInvisiblePbrtMaterial(const std::string& type) {
  return type.empty() || type == "none" || type == "interface";
}

}  // namespace skywave
