#include "scene/pbrt/material_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "scene/materials/spectrum.h"

namespace skywave {
namespace {

// Converts pbrt's roughness to a GGX width. pbrt-v3 remaps by a polynomial in log(roughness),
// pbrt-v4 by a square root.
float AlphaFromRoughness(float roughness, bool remap, bool v4) {
  if (!remap) return roughness;
  if (v4) return std::sqrt(roughness);
  const float x = std::log(std::max(roughness, 1e-3f));
  return 1.62142f + x * (0.819955f + x * (0.1734f + x * (0.0171201f + x * 0.000640711f)));
}

// Returns whether a parameter has an image, or varies in space.
bool Varies(PbrtMaterialContext& context, const std::string& name) {
  const PbrtTextures& textures = context.reader.float_textures;
  return FindImageTexture(context.parameters, name, textures) ||
         FindSolidTexture(context.parameters, name, textures);
}

struct NamedGlass {
  std::string_view name;
  float ior;  // at kIndexWavelength
};
// Indices are those of the yellow line of helium (n_d) [nm].
constexpr double kIndexWavelength = 587.6;
// These are indices from Schott's catalogue under pbrt-v4's names and its own. pbrt's F5, F10 and
// F11 hold the data of SF5, SF10 and SF11.
constexpr std::array kGlasses = {
    NamedGlass{"glass-BK7", 1.5168f},   NamedGlass{"glass-BAF10", 1.6700f},
    NamedGlass{"glass-FK51A", 1.4866f}, NamedGlass{"glass-LASF9", 1.8503f},
    NamedGlass{"glass-F5", 1.6727f},    NamedGlass{"glass-SF5", 1.6727f},
    NamedGlass{"glass-F10", 1.7283f},   NamedGlass{"glass-SF10", 1.7283f},
    NamedGlass{"glass-F11", 1.7847f},   NamedGlass{"glass-SF11", 1.7847f},
};

}  // namespace

void Warn(PbrtMaterialContext& context, std::string_view text) {
  AddWarning(context.warnings, context.parameters.position,
             fmt::format("{}: {}", context.parameters.directive, text));
}

std::optional<glm::vec3> FindFraction(PbrtMaterialContext& context, std::string_view name) {
  const auto color =
      FindColor(context.parameters, name, context.reader.color_textures, context.warnings);
  if (!color) return std::nullopt;
  const glm::vec3 clamped = glm::clamp(*color, 0.0f, 1.0f);
  if (clamped != *color) {
    AddWarning(context.warnings, context.parameters.position,
               fmt::format("{}: \"{}\" is clamped to [0, 1]", context.parameters.directive, name));
  }
  return clamped;
}

glm::vec3 FractionOr(PbrtMaterialContext& context, std::initializer_list<std::string_view> names,
                     const glm::vec3& fallback) {
  for (const std::string_view name : names) {
    if (const auto color = FindFraction(context, name)) return *color;
  }
  return fallback;
}

std::optional<float> FindScalar(PbrtMaterialContext& context, std::string_view name) {
  const auto color =
      FindColor(context.parameters, name, context.reader.float_textures, context.warnings);
  if (!color) return std::nullopt;
  return color->x;
}

void SetReflectance(PbrtMaterialContext& context, std::initializer_list<std::string_view> names,
                    float fallback, Material& material, float scale) {
  for (const std::string_view name : names) {
    const auto texture = FindImageTexture(context.parameters, name, context.reader.color_textures);
    if (!texture) continue;
    PbrtTexture scaled = *texture;
    scaled.value = scale * glm::max(texture->value.value_or(glm::vec3(1)), glm::vec3(0));
    const PbrtTexture fraction = ClampedPbrtTexture(context.reader, scaled);
    material.reflectance = *fraction.value;
    material.color_texture = fraction.image;
    return;
  }
  for (const std::string_view name : names) {
    const auto solid = FindSolidTexture(context.parameters, name, context.reader.color_textures);
    if (!solid) continue;
    context.reader.solids.push_back(
        {.use = PbrtSolidUse::kReflectance, .value = solid->solid, .fallback = fallback});
    material.reflectance = glm::vec3(scale);
    return;
  }
  material.reflectance = scale * FractionOr(context, names, glm::vec3(fallback));
}

void SetSecondColor(PbrtMaterialContext& context, std::string_view name, float fallback,
                    Material& material, float scale) {
  const auto image = FindImageTexture(context.parameters, name, context.reader.color_textures);
  if (!image) {
    material.second_color = FractionOr(context, {name}, glm::vec3(fallback)) * scale;
    return;
  }
  const PbrtTexture fraction = ClampedPbrtTexture(
      context.reader, {.value = scale * glm::max(image->value.value_or(glm::vec3(1)), glm::vec3(0)),
                       .image = image->image});
  material.second_color = *fraction.value;
  material.second_color_texture = fraction.image;
}

Widths FindWidths(PbrtMaterialContext& context, const std::string& prefix, float fallback,
                  bool v4) {
  const float roughness = Varies(context, prefix + "roughness")
                              ? fallback
                              : FindScalar(context, prefix + "roughness").value_or(fallback);
  const float u = FindScalar(context, prefix + "uroughness").value_or(roughness);
  const float v = FindScalar(context, prefix + "vroughness").value_or(roughness);
  if (!(u >= 0 && v >= 0)) {
    throw InputError(context.parameters.position,
                     context.parameters.directive + ": roughness is negative");
  }
  const bool remap = FindBool(context.parameters, "remaproughness").value_or(true);
  return {AlphaFromRoughness(u, remap, v4), AlphaFromRoughness(v, remap, v4)};
}

bool RoughnessVaries(PbrtMaterialContext& context, const std::string& prefix) {
  const auto varies = [&](const char* name) {
    const bool given = Find(context.parameters, {"float", "texture"}, prefix + name) != nullptr;
    return Varies(context, prefix + (given ? name : "roughness"));
  };
  return varies("uroughness") || varies("vroughness");
}

// Roughness along u and v overrides that of both.
Roughness FindRoughness(PbrtMaterialContext& context, const std::string& prefix, float fallback) {
  const auto find = [&](const char* name) -> std::optional<PbrtTexture> {
    const std::string full = prefix + name;
    const PbrtTextures& textures = context.reader.float_textures;
    if (auto image = FindImageTexture(context.parameters, full, textures)) return image;
    if (auto solid = FindSolidTexture(context.parameters, full, textures)) return solid;
    const auto value = FindScalar(context, full);
    if (!value) return std::nullopt;
    return PbrtTexture{.value = glm::vec3(*value)};
  };
  const PbrtTexture both = find("roughness").value_or(PbrtTexture{.value = glm::vec3(fallback)});
  return {find("uroughness").value_or(both), find("vroughness").value_or(both)};
}

Widths VariedWidths(PbrtMaterialContext& context, const std::vector<PbrtTexture>& roughness,
                    float fallback, bool v4, const PackAlphas& pack) {
  const bool remap = FindBool(context.parameters, "remaproughness").value_or(true);
  const auto alpha_of = [remap, v4](float value) { return AlphaFromRoughness(value, remap, v4); };
  const PbrtTexture packed =
      PbrtAlphaTexture(context.reader, context.parameters, roughness, alpha_of, pack);
  const float alpha = alpha_of(fallback);
  if (packed.image) return {.along = 1, .across = 1, .texture = packed.image};
  if (!packed.solid) return {alpha, alpha};
  return {.along = 1,
          .across = 1,
          .solid = PbrtSolidParameter{.use = PbrtSolidUse::kRoughness,
                                      .value = packed.solid,
                                      .fallback = std::max(alpha, 1e-3f)}};
}

float RootOfMean(float along, float across) { return std::sqrt(std::sqrt(along * across)); }

Widths FindVariedWidths(PbrtMaterialContext& context, float fallback, bool v4) {
  if (!RoughnessVaries(context, "")) return FindWidths(context, "", fallback, v4);
  const Roughness roughness = FindRoughness(context, "", fallback);
  Widths widths = VariedWidths(context, {roughness.along, roughness.across}, fallback, v4,
                               [](std::span<const float> alphas) {
                                 const float root = RootOfMean(alphas[0], alphas[1]);
                                 if (alphas[0] == alphas[1]) return glm::vec3(root);
                                 return glm::vec3(std::sqrt(alphas[1]), std::sqrt(alphas[0]), root);
                               });
  widths.texture_of_two = (widths.texture || widths.solid) && roughness.two();
  return widths;
}

float OneWidth(PbrtMaterialContext& context, const Widths& widths) {
  if (widths.along != widths.across) {
    Warn(context, fmt::format("anisotropic roughness is not supported here: rendered with the "
                              "geometric mean, alpha {:.3g}",
                              widths.mean()));
  }
  return widths.mean();
}

void SetVariedWidths(PbrtMaterialContext& context, const Widths& widths, bool rounded,
                     Material& material) {
  if (rounded) {
    Warn(context, "anisotropic roughness is not supported here: rendered with the geometric mean");
  }
  material.alpha = material.coat_alpha = widths.along;
  material.roughness_texture = widths.texture;
  if (widths.solid) context.reader.solids.push_back(*widths.solid);
}

float DielectricIndex(PbrtMaterialContext& context, std::initializer_list<std::string_view> names) {
  PbrtParameters& parameters = context.parameters;
  float ior = 1.5f;
  for (const std::string_view name : names) {
    const PbrtParameter* named = Find(parameters, {"spectrum"}, name);
    const auto* glass = named && named->strings.size() == 1
                            ? std::find_if(kGlasses.begin(), kGlasses.end(),
                                           [&](auto& g) { return g.name == named->strings[0]; })
                            : kGlasses.end();
    if (glass != kGlasses.end()) {
      ior = glass->ior;
    } else if (named && named->strings.empty()) {
      ior = float(SpectrumValueAt(PairsOf(*named), kIndexWavelength));
    } else {
      ior = FindScalar(context, name).value_or(ior);
    }
  }
  if (!(ior > 0)) {
    throw InputError(parameters.position,
                     fmt::format("{}: the index of refraction is {}", parameters.directive, ior));
  }
  return ior;
}

void SetDiffuse(PbrtMaterialContext& context, float fallback, Material& material, float scale) {
  SetReflectance(context, {"reflectance", "Kd"}, fallback, material, scale);
}

}  // namespace skywave
