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
  if (const auto& texture = material.roughness_texture) {
    PutField(record, MaterialField::kRoughnessTexture, *texture + 1);
  }
}

void PackReflection(const Material& material, MaterialRecord& record) {
  if (!material.reflection) return;
  glm::vec3 reflection = *material.reflection;
  reflection.x = std::max(reflection.x, 1e-30f);  // 0 would look like one that is unset
  PutField(record, MaterialField::kReflection, reflection);
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
  if (const auto& texture = material.second_color_texture) {
    PutField(record, MaterialField::kSecondTexture, *texture + 1);
  }
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
  if (const auto& texture = material.color_texture) {
    PutField(record, MaterialField::kColorTexture, *texture + 1);
  }
  if (bsdf.inside) {
    PutField(record, MaterialField::kAbsorption, glm::max(material.absorption, glm::vec3(0)));
  }
  if (bsdf.pack != nullptr) bsdf.pack(material, measured, record);
  return record;
}

}  // namespace skywave
