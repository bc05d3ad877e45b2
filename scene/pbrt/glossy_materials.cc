#include "scene/pbrt/glossy_materials.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "scene/pbrt/surface_maps.h"

namespace skywave {
namespace {

// Returns a material whose BSDF is the sum of those of two others: a hit has either of them, of
// which each has twice its colours.
Material Sum(PbrtMaterialContext& context, const Material& first, const Material& second) {
  std::vector<Material>& materials = context.reader.scene.materials;
  for (Material part : {first, second}) {
    part.name = fmt::format("{}, part", context.parameters.directive);
    part.reflectance *= 2, part.second_color *= 2;
    if (part.reflection) *part.reflection *= 2;
    materials.push_back(part);
  }
  const auto end = std::uint32_t(materials.size());
  // What varies in space is read for the first part.
  if (auto& solids = context.reader.solids; !solids.empty()) {
    context.reader.solid_materials.emplace(end - 2, std::exchange(solids, {}));
  }
  Material sum;
  sum.mixture = {end - 2, end - 1, 0.5f};
  return sum;
}

// Returns the width of the facets of a gloss (Ks), which is the same in all directions and places.
float GlossWidth(PbrtMaterialContext& context) {
  if (RoughnessVaries(context, "")) {
    Warn(context, "a texture of the roughness is not supported here: rendered with 0.1");
  }
  return OneWidth(context, FindWidths(context, "", 0.1f, false));
}

// Version 3 has three materials of a body (Kd) and a gloss beside it.
Material BodyAndGloss(PbrtMaterialContext& context, BsdfKind bsdf, float fallback) {
  Material material;
  material.bsdf = bsdf;
  SetDiffuse(context, fallback, material);
  SetSecondColor(context, "Ks", fallback, material);
  material.alpha = GlossWidth(context);
  return material;
}

// Sets the share of the surface that exists.
void SetOpacity(PbrtMaterialContext& context, Material& material) {
  const auto image = FindImageTexture(context.parameters, "opacity", context.reader.color_textures);
  const glm::vec3 opacity = image ? glm::clamp(image->value.value_or(glm::vec3(1)), 0.0f, 1.0f)
                                  : FractionOr(context, {"opacity"}, glm::vec3(1));
  if (opacity.x != opacity.y || opacity.y != opacity.z) {
    Warn(context, "\"opacity\" is a colour: its mean is used");
  }
  material.opacity = (opacity.x + opacity.y + opacity.z) / 3;
  if (image) {
    material.opacity_texture = CopyPbrtTexture(context.reader, *image->image, TextureUse::kOpacity);
  }
}

}  // namespace

// The facets of version 3's plastic have its index on the side of the light, and reflect all light
// at grazing angles.
Material PbrtPlastic(PbrtMaterialContext& context) {
  Material material = BodyAndGloss(context, BsdfKind::kGlossyDiffuse, 0.25f);
  material.ior = 1 / 1.5f;
  return material;
}

Material PbrtSubstrate(PbrtMaterialContext& context) {
  return BodyAndGloss(context, BsdfKind::kFresnelBlend, 0.5f);
}

Material PbrtUber(PbrtMaterialContext& context) {
  Material rough = BodyAndGloss(context, BsdfKind::kGlossyDiffuse, 0.25f);
  rough.ior = DielectricIndex(context, {"eta", "index"});
  Material smooth;
  smooth.bsdf = BsdfKind::kDielectric;
  smooth.ior = rough.ior;
  smooth.reflection = FractionOr(context, {"Kr"}, glm::vec3(0));
  smooth.reflectance = FractionOr(context, {"Kt"}, glm::vec3(0));
  const bool both = *smooth.reflection != glm::vec3(0) || smooth.reflectance != glm::vec3(0);
  Material material = both ? Sum(context, rough, smooth) : rough;
  SetOpacity(context, material);
  return material;
}

// Either side has a body, Kd, and a gloss, Ks, each times the share of light that goes there.
Material PbrtTranslucent(PbrtMaterialContext& context) {
  const glm::vec3 reflect = FractionOr(context, {"reflect"}, glm::vec3(0.5f));
  const glm::vec3 transmit = FractionOr(context, {"transmit"}, glm::vec3(0.5f));
  Material body;
  body.bsdf = BsdfKind::kDiffuseTransmission;
  SetDiffuse(context, 0.25f, body);
  for (const PbrtSolidParameter& solid : context.reader.solids) {
    if (solid.use != PbrtSolidUse::kReflectance) continue;
    Warn(context, "\"Kd\" varies in space: it colours what is reflected alone");
  }
  body.second_color = body.reflectance * transmit, body.reflectance *= reflect;
  body.second_color_texture = body.color_texture;
  const glm::vec3 gloss = FractionOr(context, {"Ks"}, glm::vec3(0.25f));
  Material facets;
  facets.bsdf = BsdfKind::kRoughDielectric;
  facets.reflectance = gloss * transmit, facets.reflection = gloss * reflect;
  facets.alpha = GlossWidth(context);
  facets.energy_compensation = false;
  return gloss == glm::vec3(0) ? body : Sum(context, body, facets);
}

}  // namespace skywave
