#include "kernels/bsdf/pack.h"

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/conductor_tables.h"

namespace skywave {
namespace {

template <class T>
void PutWords(MaterialRecord& record, MaterialField field, const T& value) {
  auto* const words = reinterpret_cast<unsigned char*>(&record);
  std::memcpy(words + sizeof(std::uint32_t) * std::uint32_t(field), &value, sizeof value);
}

}  // namespace

void PutField(MaterialRecord& record, MaterialField field, float value) {
  PutWords(record, field, value);
}
void PutField(MaterialRecord& record, MaterialField field, const glm::vec3& value) {
  PutWords(record, field, value);
}
void PutField(MaterialRecord& record, MaterialField field, std::uint32_t value) {
  PutWords(record, field, value);
}

void PutTexture(MaterialRecord& record, MaterialField field,
                const std::optional<std::uint32_t>& texture) {
  if (texture) PutField(record, field, *texture + 1);
}

float MicrofacetWidth(float alpha) { return std::clamp(alpha, 1e-3f, 1.0f); }

void PackConductorIndex(const Material& material, MaterialRecord& record) {
  // No index is negative (MetalOfColor); other BSDFs do not use this field.
  const bool knows = material.bsdf == BsdfKind::kConductor ||
                     material.bsdf == BsdfKind::kAnisotropicConductor ||
                     material.bsdf == BsdfKind::kBeckmannConductor;
  const glm::vec3 eta = knows && material.metal_of_color ? glm::vec3(-1) : material.eta;
  PutField(record, MaterialField::kEta, eta);
  PutField(record, MaterialField::kK, material.k);
}

void PackAlpha(const Material& material, MaterialRecord& record) {
  PutField(record, MaterialField::kAlpha, MicrofacetWidth(material.alpha));
  PutTexture(record, MaterialField::kRoughnessTexture, material.roughness_texture);
}

void PackReflection(const Material& material, MaterialRecord& record) {
  if (!material.reflection) return;
  glm::vec3 reflection = *material.reflection;
  reflection.x = std::max(reflection.x, 1e-30f);  // 0 would look like one that is unset
  PutField(record, MaterialField::kReflection, reflection);
}

void PackReflectionLayers(const Material& material, MaterialField thin, MaterialField thick,
                          MaterialRecord& record) {
  PutField(record, MaterialField::kSpecular, material.specular);
  PutField(record, MaterialField::kSpecularColor, material.specular_color);
  PutTexture(record, MaterialField::kSpecularTexture, material.specular_texture);
  PutTexture(record, MaterialField::kSpecularColorTexture, material.specular_color_texture);
  PutField(record, MaterialField::kFilm, material.film);
  PutField(record, MaterialField::kFilmIor, material.film_ior);
  PutField(record, thin, material.film_thin);
  PutField(record, thick, material.film_thick);
  PutTexture(record, MaterialField::kFilmTexture, material.film_texture);
  PutTexture(record, MaterialField::kFilmThicknessTexture, material.film_thickness_texture);
}
void PackGlassLayers(const Material& material, MaterialRecord& record) {
  PackReflectionLayers(material, MaterialField::kGlassFilmThin, MaterialField::kGlassFilmThick,
                       record);
}

void PackGlassCoat(const Material& material, MaterialRecord& record) {
  PutField(record, MaterialField::kGlassCoat, material.coat);
  PutField(record, MaterialField::kGlassCoatAlpha, MicrofacetWidth(material.coat_alpha));
}

void PackMultiscatter(const Material& material, MaterialRecord& record, const MultiscatterOf& of) {
  if (!material.energy_compensation) return;
  glm::vec3 factors;
  for (int c = 0; c < 3; ++c) factors[c] = of(material.eta[c], material.k[c]);
  // A channel that reflects nothing must not look like a material without compensation.
  factors.x = std::max(factors.x, 1e-30f);
  PutField(record, MaterialField::kMultiscatter, factors);
}

void PackConductor(const Material& material, MaterialRecord& record) {
  const float alpha = MicrofacetWidth(material.alpha);
  PackAlpha(material, record);
  PackConductorIndex(material, record);
  PackMultiscatter(material, record, [&](float eta, float k) {
    return ConductorMultiscatter(GgxTables(), alpha, eta, k);
  });
}

void PackWidths(const Material& material, MaterialRecord& record) {
  const float across = material.alpha_across.value_or(material.alpha);
  PutField(record, MaterialField::kAlpha, MicrofacetWidth(material.alpha));
  PutField(record, MaterialField::kAlphaAcross, MicrofacetWidth(across));
}

void PackSecondColor(const Material& material, MaterialField field, MaterialRecord& record) {
  PutField(record, field, material.second_color);
  PutTexture(record, MaterialField::kSecondTexture, material.second_color_texture);
}

void PackBodyAndGloss(const Material& material, MaterialRecord& record) {
  PutField(record, MaterialField::kAlpha, MicrofacetWidth(material.alpha));
  PackSecondColor(material, MaterialField::kGloss, record);
}

void PackMetallicRoughness(const Material& material, MaterialRecord& record) {
  PackAlpha(material, record);
  PutField(record, MaterialField::kMetallic, material.metallic);
  PutField(record, MaterialField::kIor, material.ior);
}

void PackCoatAndSheen(const Material& material, MaterialRecord& record) {
  PackMetallicRoughness(material, record);
  PutField(record, MaterialField::kClearCoat, material.coat);
  PutField(record, MaterialField::kClearCoatAlpha, MicrofacetWidth(material.coat_alpha));
  PutField(record, MaterialField::kSheen, material.sheen);
  PutField(record, MaterialField::kSheenAlpha, MicrofacetWidth(material.sheen_alpha));
}

bool HasTangent(const Material& material) {
  const BsdfTraits& bsdf = Bsdfs()[std::size_t(material.bsdf)];
  return bsdf.varying == Varying::kTangent || (bsdf.two_widths && material.alpha_across) ||
         (bsdf.varying == Varying::kLayers && material.anisotropy > 0);
}

MaterialRecord PackMaterial(const Material& material, MeasuredBrdfs measured) {
  const BsdfKernels& bsdf = Bsdfs()[std::size_t(material.bsdf)];
  MaterialRecord record = {};
  PutField(record, MaterialField::kColor, material.reflectance);
  PutTexture(record, MaterialField::kColorTexture, material.color_texture);
  if (bsdf.inside) {
    PutField(record, MaterialField::kAbsorption, glm::max(material.absorption, glm::vec3(0)));
  }
  if (bsdf.pack != nullptr) bsdf.pack(material, measured, record);
  return record;
}

}  // namespace skywave
