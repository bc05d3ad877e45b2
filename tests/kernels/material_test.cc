// Tests materials as data: no part of one is forgotten, and BSDFs pack what they claim to read.

#include "kernels/bsdf/material.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"
#include "tests/support/changed_field.h"
#include "tests/support/shading_rows.h"

namespace skywave {
namespace {

TEST(Material, VisitsEveryMemberButTheName) {
  const Material m;
  // There are as many names as members: a new member compiles neither here nor without its line
  // below.
  const auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17, m18,
               m19, m20, m21, m22, m23, m24, m25, m26, m27, m28, m29, m30, m31, m32, m33, m34, m35,
               m36, m37, m38, m39, m40, m41, m42, m43, m44, m45, m46, m47, m48, m49, m50, m51, m52,
               m53, m54, m55, m56, m57, m58, m59] = m;
  constexpr std::size_t kMembers = 60;
  const std::map<std::string_view, const void*> members = {
      {"bsdf", &m.bsdf},
      {"reflectance", &m.reflectance},
      {"one_sided", &m.one_sided},
      {"catcher", &m.catcher},
      {"holdout", &m.holdout},
      {"unlit", &m.unlit},
      {"unshadowed", &m.unshadowed},
      {"eta", &m.eta},
      {"k", &m.k},
      {"alpha", &m.alpha},
      {"alpha_across", &m.alpha_across},
      {"ior", &m.ior},
      {"metallic", &m.metallic},
      {"second_color", &m.second_color},
      {"coat", &m.coat},
      {"coat_alpha", &m.coat_alpha},
      {"coat_thickness", &m.coat_thickness},
      {"coat_albedo", &m.coat_albedo},
      {"coat_asymmetry", &m.coat_asymmetry},
      {"sheen", &m.sheen},
      {"sheen_alpha", &m.sheen_alpha},
      {"measured", &m.measured},
      {"own_base_normals", &m.own_base_normals},
      {"base_normal_texture", &m.base_normal_texture},
      {"base_normal_scale", &m.base_normal_scale},
      {"specular", &m.specular},
      {"specular_color", &m.specular_color},
      {"anisotropy", &m.anisotropy},
      {"anisotropy_turn", &m.anisotropy_turn},
      {"film", &m.film},
      {"film_ior", &m.film_ior},
      {"film_thin", &m.film_thin},
      {"film_thick", &m.film_thick},
      {"sheen_texture", &m.sheen_texture},
      {"sheen_alpha_texture", &m.sheen_alpha_texture},
      {"coat_alpha_texture", &m.coat_alpha_texture},
      {"specular_texture", &m.specular_texture},
      {"specular_color_texture", &m.specular_color_texture},
      {"anisotropy_texture", &m.anisotropy_texture},
      {"film_texture", &m.film_texture},
      {"film_thickness_texture", &m.film_thickness_texture},
      {"absorption", &m.absorption},
      {"metal_of_color", &m.metal_of_color},
      {"energy_compensation", &m.energy_compensation},
      {"second_color_texture", &m.second_color_texture},
      {"color_texture", &m.color_texture},
      {"roughness_texture", &m.roughness_texture},
      {"opacity", &m.opacity},
      {"opacity_cutoff", &m.opacity_cutoff},
      {"opacity_texture", &m.opacity_texture},
      {"normal_texture", &m.normal_texture},
      {"normal_scale", &m.normal_scale},
      {"height_in_texels", &m.height_in_texels},
      {"reflection", &m.reflection},
      {"mixture", &m.mixture},
      {"mixture_texture", &m.mixture_texture},
      {"emission", &m.emission},
      {"emits_on_both_sides", &m.emits_on_both_sides},
      {"emission_texture", &m.emission_texture}};
  ASSERT_EQ(members.size() + 1, kMembers);
  EXPECT_EQ(&m0, &m.name);
  std::map<std::string_view, const void*> visited;
  Material::ForEachField(m, [&](std::string_view name, MaterialPart, const auto& field) {
    EXPECT_TRUE(visited.emplace(name, &field).second) << name;
  });
  EXPECT_EQ(visited, members);
}

TEST(Material, NamesItsTextures) {
  Material m;
  m.color_texture = 3, m.roughness_texture = 1, m.opacity_texture = 4, m.normal_texture = 5;
  m.emission_texture = 9, m.measured = 2, m.alpha_across = 0.5f;
  std::multiset<std::uint32_t> textures;
  ForEachTexture(m, [&](std::uint32_t texture) { textures.insert(texture); });
  EXPECT_EQ(textures, (std::multiset<std::uint32_t>{1, 3, 4, 5, 9}));
}

class PackedBsdf : public testing::TestWithParam<std::uint32_t> {
 protected:
  const BsdfKernels& bsdf_ = Bsdfs()[GetParam()];
  const std::vector<MeasuredBrdf> measured_ = {{.rgb = {}, .alpha = 0.3f, .specular_share = 0.5f},
                                               {.rgb = {}, .alpha = 0.2f, .specular_share = 0.4f}};
};

bool Lists(const BsdfTraits& bsdf, std::string_view field) {
  const auto parameters = ParametersOf(bsdf);
  return std::any_of(parameters.begin(), parameters.end(),
                     [&](const MaterialParameter& p) { return p.field == field; });
}

TEST_P(PackedBsdf, ReadsFieldsOfMaterialsUnderDistinctNames) {
  std::set<std::string_view> fields, names;
  const Material material;
  Material::ForEachField(material, [&](std::string_view name, MaterialPart part, const auto&) {
    if (part == MaterialPart::kBsdf || part == MaterialPart::kReflection ||
        part == MaterialPart::kLayers || part == MaterialPart::kReflectionLayers) {
      fields.insert(name);
    }
  });
  for (const MaterialParameter& parameter : ParametersOf(bsdf_)) {
    EXPECT_TRUE(fields.contains(parameter.field)) << parameter.field;
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
  }
}

// The record depends on the fields that the traits list, and on those common to all BSDFs.
TEST_P(PackedBsdf, PacksTheParametersThatItLists) {
  const Material base = MaterialOfAllParts(BsdfKind(GetParam()));
  const MaterialRecord before = PackMaterial(base, measured_);
  Material changed = base;
  Material::ForEachField(changed, [&](std::string_view name, MaterialPart part, auto& field) {
    if (name == "bsdf") return;
    changed = base;
    ChangeField(field);
    const MaterialRecord after = PackMaterial(changed, measured_);
    const bool common = name == "reflectance" || name == "color_texture";
    const bool read = common || Lists(bsdf_, name) ||
                      (name == "roughness_texture" &&
                       (bsdf_.varying == Varying::kRoughness || bsdf_.varying == Varying::kAlpha ||
                        bsdf_.varying == Varying::kLayers ||
                        bsdf_.varying == Varying::kCoatWidths || bsdf_.across)) ||
                      (name == "second_color_texture" && bsdf_.varying == Varying::kSecondColor) ||
                      (part == MaterialPart::kLayerTextures && bsdf_.varying == Varying::kLayers) ||
                      (part == MaterialPart::kReflectionLayerTextures &&
                       (bsdf_.glass_layers || bsdf_.varying == Varying::kLayers)) ||
                      (part == MaterialPart::kMetalOfColor && bsdf_.name.ends_with("conductor") &&
                       !bsdf_.name.starts_with("coated")) ||
                      (part == MaterialPart::kSingleScattering &&
                       (bsdf_.name == "conductor" || bsdf_.name == "anisotropic-conductor" ||
                        bsdf_.name.ends_with("rough-dielectric") ||
                        bsdf_.name.ends_with("rough-thin-dielectric"))) ||
                      (part == MaterialPart::kAbsorption && bsdf_.inside);
    EXPECT_EQ(WordsOf(before) != WordsOf(after), read) << name;
  });
}

INSTANTIATE_TEST_SUITE_P(All, PackedBsdf, testing::Range(0u, kBsdfKinds), [](const auto& kind) {
  std::string name(Bsdfs()[kind.param].name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace skywave
