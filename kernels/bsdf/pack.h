// How a material becomes a MaterialRecord: what BSDFs need to write their `pack` (BsdfTraits).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <optional>
#include <string_view>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/material.h"

#include "kernels/columns.h"

namespace skywave {

// These write a field of `record`.
void PutField(MaterialRecord& record, MaterialField field, float value);
void PutField(MaterialRecord& record, MaterialField field, const glm::vec3& value);
void PutField(MaterialRecord& record, MaterialField field, std::uint32_t value);
// Writes the row of a texture, if there is one.
void PutTexture(MaterialRecord& record, MaterialField field,
                const std::optional<std::uint32_t>& texture);

// Returns a width of microfacets that kernels can take: it is clamped to [0.001, 1].
float MicrofacetWidth(float alpha);

// These pack the parameters that several BSDFs have in common: eta and k of a conductor;
void PackConductorIndex(const Material& material, MaterialRecord& record);
// alpha and its texture;
void PackAlpha(const Material& material, MaterialRecord& record);
// the factor of what a dielectric reflects;
void PackReflection(const Material& material, MaterialRecord& record);
// a share and a colour of what a dielectric reflects, and a film of thicknesses in these fields;
void PackReflectionLayers(const Material& material, MaterialField thin, MaterialField thick,
                          MaterialRecord& record);
// those of glass;
void PackGlassLayers(const Material& material, MaterialRecord& record);
// its coat;
void PackGlassCoat(const Material& material, MaterialRecord& record);
// what facets reflect more than once, by of(eta, k) of each channel, or 0 without compensation;
using MultiscatterOf = std::function<float(float eta, float k)>;
void PackMultiscatter(const Material& material, MaterialRecord& record, const MultiscatterOf& of);
// alpha, eta and k of a conductor with multiple scattering;
void PackConductor(const Material& material, MaterialRecord& record);
// alpha and alpha_across of anisotropic facets;
void PackWidths(const Material& material, MaterialRecord& record);
// the second colour, which is `field`, and its texture;
void PackSecondColor(const Material& material, MaterialField field, MaterialRecord& record);
// alpha and the second colour of a body and a gloss;
void PackBodyAndGloss(const Material& material, MaterialRecord& record);
// alpha, its texture, metallic and ior of metallic-roughness;
void PackMetallicRoughness(const Material& material, MaterialRecord& record);
// these and what lies over it: coat and sheen.
void PackCoatAndSheen(const Material& material, MaterialRecord& record);

// Returns the traits with more parameters.
constexpr BsdfTraits WithParameters(BsdfTraits traits, std::initializer_list<const char*> names) {
  std::size_t count = 0;
  while (!traits.parameters[count].name.empty()) ++count;
  for (const char* const name : names) traits.parameters[count++] = {name};
  return traits;
}
// Returns the traits of a BSDF of glass, which may also have the layers that PackGlassLayers packs.
constexpr BsdfTraits WithGlassLayers(BsdfTraits traits) {
  traits.glass_layers = true;
  return WithParameters(
      traits, {"specular", "specular_color", "film", "film_ior", "film_thin", "film_thick"});
}
// Returns those of glass under the coat that PackGlassCoat packs, which `pack` calls.
constexpr BsdfTraits UnderCoat(BsdfTraits glass, std::string_view name,
                               decltype(BsdfTraits::pack) pack) {
  glass.name = name;
  glass.tables.ggx = true;
  glass.pack = pack;
  return WithParameters(glass, {"coat", "coat_alpha"});
}

// Returns the record of `material`: the fields that all BSDFs have and those that its own BSDF
// packs. Materials name the tables `measured` by their index.
MaterialRecord PackMaterial(const Material& material, MeasuredBrdfs measured);

}  // namespace skywave
