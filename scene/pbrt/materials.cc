#include "scene/pbrt/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/materials/merl.h"
#include "scene/materials/metals.h"
#include "scene/materials/spectrum.h"
#include "scene/pbrt/glossy_materials.h"
#include "scene/pbrt/material_parameters.h"
#include "scene/pbrt/state.h"

namespace skywave {
namespace {

using Context = PbrtMaterialContext;

Material Lambert(Context& context) {
  Material material;
  SetDiffuse(context, 0.5f, material);
  return material;
}

// sigma is the standard deviation of the facets' angles [degrees]. The energy-preserving model has
// the shape of Oren and Nayar's when it uses their ratio B / A of the two terms (1994, "qualitative
// model").
float OrenNayarRoughness(float sigma_degrees) {
  const float sigma = sigma_degrees * 0.0174532925f, sigma2 = sigma * sigma;
  const float a = 1 - 0.5f * sigma2 / (sigma2 + 0.33f), b = 0.45f * sigma2 / (sigma2 + 0.09f);
  return std::min(b / a, 1.0f);
}

Material Matte(Context& context) {
  Material material = Lambert(context);
  const float sigma = FindScalar(context, "sigma").value_or(0);
  if (!(sigma >= 0)) {
    throw InputError(context.parameters.position,
                     context.parameters.directive + ": \"sigma\" is negative");
  }
  if (sigma > 0) {
    material.bsdf = BsdfKind::kOrenNayar;
    material.alpha = OrenNayarRoughness(sigma);
  }
  return material;
}

// Returns the largest value of each channel of a texture, or 1 without one.
glm::vec3 Brightest(const Context& context, const std::optional<std::uint32_t>& texture) {
  if (!texture) return glm::vec3(1);
  const Scene& scene = context.reader.scene;
  const CompactImage& image = scene.images[scene.textures[*texture].image];
  glm::vec3 most(0);
  for (std::size_t i = 0; i < image.values(); ++i) {
    most[int(i % 3)] = std::max(most[int(i % 3)], image.Value(i));
  }
  return most;
}

Material DiffuseTransmission(Context& context) {
  const float scale = FindScalar(context, "scale").value_or(1);
  if (!(scale >= 0)) {
    throw InputError(context.parameters.position,
                     context.parameters.directive + ": \"scale\" is negative");
  }
  Material material;
  material.bsdf = BsdfKind::kDiffuseTransmission;
  SetDiffuse(context, 0.25f, material, scale);
  SetSecondColor(context, "transmittance", 0.25f, material, scale);
  const glm::vec3 sum = material.reflectance * Brightest(context, material.color_texture) +
                        material.second_color * Brightest(context, material.second_color_texture);
  const float largest = std::max({sum.x, sum.y, sum.z});
  if (largest > 1) {
    Warn(context, "reflectance and transmittance exceed 1 in sum: both are scaled down");
    material.reflectance /= largest, material.second_color /= largest;
  }
  return material;
}

Material LambertInstead(Context& context) {
  AddWarning(context.warnings, context.parameters.position,
             fmt::format("{} is not supported: rendered as Lambert of its diffuse colour",
                         context.parameters.directive));
  Material material = Lambert(context);
  UseAll(context.parameters);
  return material;
}

Material Mirror(Context& context) {
  Material material;
  material.bsdf = BsdfKind::kMirror;
  material.reflectance = FractionOr(context, {"Kr"}, glm::vec3(0.9f));
  return material;
}

// Returns the metal of "metal-Cu-eta" (v4) or "spds/Cu.eta.spd" (v3) if it is known.
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

// `part` is "eta" or "k"; the parameter's name is `prefix` followed by it.
glm::vec3 ConductorIndex(Context& context, const std::string& prefix, const std::string& part,
                         const MetalIndex& fallback) {
  const std::string name = prefix + part;
  const auto pick = [&](const MetalIndex& metal) { return part == "eta" ? metal.eta : metal.k; };
  if (const PbrtParameter* named = Find(context.parameters, {"spectrum"}, name);
      named && named->strings.size() == 1) {
    if (const auto metal = MetalOfSpectrumName(named->strings[0], part)) return pick(*metal);
  }
  const auto color =
      FindColor(context.parameters, name, context.reader.color_textures, context.warnings);
  if (color && !glm::all(glm::greaterThanEqual(*color, glm::vec3(0)))) {
    throw InputError(context.parameters.position,
                     fmt::format("{}: \"{}\" is negative", context.parameters.directive, name));
  }
  return color.value_or(pick(fallback));
}

// Sets the index of a conductor, or the image of its reflectance; `prefix` begins the names of the
// index in coated ones, which have no image.
void SetIndex(Context& context, const std::string& prefix, Material& material) {
  const auto image =
      FindImageTexture(context.parameters, "reflectance", context.reader.color_textures);
  if (image && prefix.empty()) {
    const PbrtTexture fraction = ClampedPbrtTexture(
        context.reader, {.value = glm::max(image->value.value_or(glm::vec3(1)), glm::vec3(0)),
                         .image = image->image});
    material.metal_of_color = true;
    material.reflectance = *fraction.value;
    material.color_texture = fraction.image;
    return;
  }
  if (const auto reflectance = FindFraction(context, "reflectance")) {
    const MetalIndex index = MetalOfReflectance(*reflectance);
    material.eta = index.eta;
    material.k = index.k;
    return;
  }
  const MetalIndex copper = *FindMetal("Cu");
  material.eta = ConductorIndex(context, prefix, "eta", copper);
  material.k = ConductorIndex(context, prefix, "k", copper);
}

Material Conductor(Context& context, bool v4) {
  Material material;
  material.bsdf = BsdfKind::kConductor;
  material.reflectance = glm::vec3(1);
  SetIndex(context, "", material);
  const Widths widths = FindVariedWidths(context, v4 ? 0.0f : 0.01f, v4);
  material.alpha = widths.mean();
  material.roughness_texture = widths.texture;
  if (widths.solid) context.reader.solids.push_back(*widths.solid);
  // A mirror has the same index everywhere; facets of the least width are nearly a mirror.
  if (widths.smooth() && !material.metal_of_color) {
    material.bsdf = BsdfKind::kMirror;
  } else if (widths.two()) {
    material.bsdf = BsdfKind::kAnisotropicConductor;
    material.alpha = widths.along, material.alpha_across = widths.across;
  }
  return material;
}

// Reads the medium between the interfaces of a coat. Its thickness is an optical one, as pbrt has
// it. pbrt's default is 0.01 without scattering, which absorbs 2 to 6 % of the light of a coat
// although no file asked for that; here a medium counts only if the file gives one.
void SetCoatMedium(Context& context, Material& material) {
  const auto albedo = FindFraction(context, "albedo");
  const auto thickness = FindScalar(context, "thickness"), asymmetry = FindScalar(context, "g");
  if (!(thickness.value_or(0) >= 0 && std::fabs(asymmetry.value_or(0)) < 1)) {
    throw InputError(context.parameters.position,
                     context.parameters.directive +
                         ": \"thickness\" is negative, or \"g\" is not between -1 and 1");
  }
  material.coat_albedo = albedo.value_or(glm::vec3(0));
  const bool scatters = material.coat_albedo != glm::vec3(0);
  material.coat_thickness = thickness.value_or(scatters ? 0.01f : 0.0f);
  material.coat_asymmetry = asymmetry.value_or(0);
  // These bound pbrt's random walk, which is followed to its end here.
  for (const char* name : {"maxdepth", "nsamples"}) FindInt(context.parameters, name);
}

Material CoatedConductor(Context& context) {
  Material material;
  material.bsdf = BsdfKind::kCoatedConductor;
  material.reflectance = glm::vec3(1);
  SetIndex(context, "conductor.", material);
  if (RoughnessVaries(context, "conductor.") || RoughnessVaries(context, "interface.")) {
    const Roughness metal = FindRoughness(context, "conductor.", 0),
                    coat = FindRoughness(context, "interface.", 0);
    const Widths widths =
        VariedWidths(context, {metal.along, metal.across, coat.along, coat.across}, 0, true,
                     [](std::span<const float> alphas) {
                       const float root = RootOfMean(alphas[0], alphas[1]);
                       return glm::vec3(RootOfMean(alphas[2], alphas[3]), root, root);
                     });
    SetVariedWidths(context, widths, metal.two() || coat.two(), material);
  } else {
    material.alpha = OneWidth(context, FindWidths(context, "conductor.", 0, true));
    material.coat_alpha = OneWidth(context, FindWidths(context, "interface.", 0, true));
  }
  material.ior = DielectricIndex(context, {"interface.eta"});
  SetCoatMedium(context, material);
  return material;
}

Material CoatedDiffuse(Context& context) {
  Material material;
  material.bsdf = BsdfKind::kCoatedDiffuse;
  SetDiffuse(context, 0.5f, material);
  if (RoughnessVaries(context, "")) {
    const Roughness roughness = FindRoughness(context, "", 0);
    const Widths widths = VariedWidths(
        context, {roughness.along, roughness.across}, 0, true,
        [](std::span<const float> alphas) { return glm::vec3(RootOfMean(alphas[0], alphas[1])); });
    SetVariedWidths(context, widths, roughness.two(), material);
  } else {
    material.alpha = OneWidth(context, FindWidths(context, "", 0, true));
  }
  material.ior = DielectricIndex(context, {"eta"});
  SetCoatMedium(context, material);
  return material;
}

Material Dielectric(Context& context, bool v4) {
  Material material;
  material.bsdf = BsdfKind::kDielectric;
  material.reflectance = glm::vec3(1);
  material.ior = DielectricIndex(context, {"eta", "index"});
  const Widths widths = FindVariedWidths(context, 0, v4);
  material.roughness_texture = widths.texture;
  // Without roughness, v3's polynomial would still give a width.
  const auto gives_roughness = [&](const PbrtParameter& parameter) {
    if (!parameter.name.ends_with("roughness")) return false;
    if (parameter.type != "texture") return !parameter.floats.empty() && parameter.floats[0] != 0;
    const auto& known = context.reader.float_textures;
    const auto texture =
        parameter.strings.size() == 1 ? known.find(parameter.strings[0]) : known.end();
    return texture != known.end() && texture->second.value.value_or(glm::vec3(0)).x != 0;
  };
  const bool rough = std::any_of(context.parameters.list.begin(), context.parameters.list.end(),
                                 gives_roughness) ||
                     widths.texture || widths.solid;
  // A rough surface between equal indices refracts nothing, so its facets are undetermined.
  if (rough && !widths.smooth() && std::fabs(material.ior - 1) > 1e-3f) {
    material.bsdf = BsdfKind::kRoughDielectric;
    material.alpha = widths.mean();
    if (widths.two()) {
      material.alpha = widths.along, material.alpha_across = widths.across;
    }
    if (widths.solid) context.reader.solids.push_back(*widths.solid);
  }
  // Only version 3 has these: factors of what is reflected and of what passes.
  SetReflectance(context, {"Kt"}, 1, material);
  const glm::vec3 reflection = FractionOr(context, {"Kr"}, glm::vec3(1));
  const bool varies = Find(context.parameters, {"texture"}, "Kt") != nullptr;
  if (varies || reflection != material.reflectance) material.reflection = reflection;
  return material;
}

Material ThinDielectric(Context& context) {
  Material material;
  material.bsdf = BsdfKind::kThinDielectric;
  material.reflectance = glm::vec3(1);
  material.ior = DielectricIndex(context, {"eta"});
  return material;
}

// Reads a BRDF in the MERL format, as pbrt did up to version 2.
Material Measured(Context& context) {
  const auto file = FindString(context.parameters, "filename");
  if (!file) {
    throw InputError(context.parameters.position,
                     context.parameters.directive + " needs a \"string filename\"");
  }
  if (!file->ends_with(".binary")) {
    Warn(context,
         "only BRDFs of the MERL format (.binary) are supported: rendered as grey Lambert");
    return Material{};
  }
  Material material;
  material.bsdf = BsdfKind::kMeasured;
  material.reflectance = glm::vec3(1);
  std::vector<MeasuredBrdf>& measured = context.reader.scene.measured;
  material.measured = std::uint32_t(measured.size());
  measured.push_back(ReadMerl(ResolvePbrtPath(context.reader, *file, context.parameters.position)));
  return material;
}

// pbrt-v4 has "materials" and the share of the second; pbrt-v3 has "namedmaterial1",
// "namedmaterial2" and the share of the first.
Material Mix(Context& context) {
  PbrtParameters& parameters = context.parameters;
  std::vector<std::string> names;
  const PbrtParameter* list = Find(parameters, {"string"}, "materials");
  if (list != nullptr) names = list->strings;
  for (const char* name : {"namedmaterial1", "namedmaterial2"}) {
    if (const auto named = FindString(parameters, name)) names.push_back(*named);
  }
  if (names.size() != 2) {
    throw InputError(parameters.position, parameters.directive + " needs the names of 2 materials");
  }
  std::uint32_t rows[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& known = context.reader.named_materials;
    const auto found = known.find(names[i]);
    if (found == known.end() || !found->second) {
      throw InputError(parameters.position, fmt::format("{}: there is no material \"{}\" to mix",
                                                        parameters.directive, names[i]));
    }
    rows[i] = *found->second;
  }
  Material material;
  // The amount is a colour in version 3 and a float in version 4.
  for (const PbrtTextures* const textures :
       {&context.reader.float_textures, &context.reader.color_textures}) {
    if (const auto shares = FindImageTexture(parameters, "amount", *textures)) {
      material.mixture = {rows[0], rows[1], 0.5f};
      material.mixture_texture = PbrtShareTexture(context.reader, *shares, list == nullptr);
      return material;
    }
    if (const auto shares = FindSolidTexture(parameters, "amount", *textures)) {
      const bool inverted = list == nullptr;
      const auto share = [inverted, share_at = shares->solid](const PbrtPoint& point) {
        const glm::vec3 color = (*share_at)(point);
        const float value = std::clamp((color.x + color.y + color.z) / 3, 0.0f, 1.0f);
        return glm::vec3(inverted ? 1 - value : value);
      };
      material.mixture = {rows[0], rows[1], 0.5f};
      context.reader.solids.push_back({.use = PbrtSolidUse::kShare,
                                       .value = std::make_shared<const PbrtSolid>(share),
                                       .fallback = 0.5f});
      return material;
    }
  }
  const PbrtParameter* const texture = Find(context.parameters, {"texture"}, "amount");
  const bool scalar = texture != nullptr && texture->strings.size() == 1 &&
                      !context.reader.color_textures.contains(texture->strings[0]);
  const glm::vec3 amount =
      scalar ? glm::vec3(glm::clamp(FindScalar(context, "amount").value_or(0.5f), 0.0f, 1.0f))
             : FractionOr(context, {"amount"}, glm::vec3(0.5f));
  if (amount.x != amount.y || amount.y != amount.z) {
    Warn(context, "\"amount\" is a colour: its mean is used");
  }
  const float mean = (amount.x + amount.y + amount.z) / 3;
  material.mixture = {rows[0], rows[1], list != nullptr ? mean : 1 - mean};
  return material;
}

Material ByType(const std::string& type, Context& context) {
  if (type == "diffuse") return Lambert(context);
  if (type == "matte") return Matte(context);
  if (type == "mirror") return Mirror(context);
  if (type == "metal") return Conductor(context, false);
  if (type == "conductor") return Conductor(context, true);
  if (type == "coatedconductor") return CoatedConductor(context);
  if (type == "glass") return Dielectric(context, false);
  if (type == "dielectric") return Dielectric(context, true);
  if (type == "thindielectric") return ThinDielectric(context);
  if (type == "diffusetransmission") return DiffuseTransmission(context);
  if (type == "translucent") return PbrtTranslucent(context);
  if (type == "coateddiffuse") return CoatedDiffuse(context);
  if (type == "plastic") return PbrtPlastic(context);
  if (type == "uber") return PbrtUber(context);
  if (type == "substrate") return PbrtSubstrate(context);
  if (type == "measured") return Measured(context);
  if (type == "mix") return Mix(context);
  for (const char* other : {"shinymetal", "disney"}) {
    if (type == other) return LambertInstead(context);
  }
  AddWarning(context.warnings, context.parameters.position,
             context.parameters.directive + " is not supported: rendered as grey Lambert");
  UseAll(context.parameters);
  return Material{};
}

}  // namespace

Material MakePbrtMaterial(const std::string& type, PbrtParameters& parameters, PbrtReader& reader) {
  Context context{parameters, reader};
  Material material = ByType(type, context);
  ReportUnused(parameters, reader.warnings);
  return material;
}

bool IsInvisiblePbrtMaterial(const std::string& type) {
  return type.empty() || type == "none" || type == "interface";
}

}  // namespace skywave
