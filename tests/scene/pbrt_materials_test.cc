// Tests materials of pbrt scenes in both versions: names, defaults, glasses, metals and colors.
// Numbers are computed by hand from pbrt's conventions.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "base/error.h"
#include "scene/materials/spectrum.h"
#include "scene/reader.h"
#include "tests/support/expect_near.h"
#include "tests/support/pbrt_texts.h"

namespace skywave {
namespace {

TEST(Materials, NamesOfBothVersionsAreRead) {
  ExpectNear(OnlyMaterial("").reflectance, glm::vec3(0.5f));
  const Material matte = OnlyMaterial("Material \"matte\" \"color Kd\" [.1 .2 .3]");
  EXPECT_EQ(matte.bsdf, BsdfKind::kLambert);
  ExpectNear(matte.reflectance, {0.1f, 0.2f, 0.3f});
  ExpectNear(OnlyMaterial("Material \"diffuse\" \"rgb reflectance\" [.4 .5 .6]").reflectance,
             {0.4f, 0.5f, 0.6f});
  ExpectNear(OnlyMaterial("Material \"matte\" \"float Kd\" .25").reflectance, glm::vec3(0.25f));
  ExpectNear(
      OnlyMaterial("Material \"diffuse\" \"spectrum reflectance\" [400 .7 700 .7]").reflectance,
      glm::vec3(0.7f));
  const Material mirror = OnlyMaterial("Material \"mirror\" \"rgb Kr\" [.8 .7 .6]");
  EXPECT_EQ(mirror.bsdf, BsdfKind::kMirror);
  ExpectNear(mirror.reflectance, {0.8f, 0.7f, 0.6f});
  ExpectNear(OnlyMaterial("Material \"mirror\"").reflectance, glm::vec3(0.9f));
  const Material glass = OnlyMaterial("Material \"glass\" \"float index\" 1.33");
  EXPECT_EQ(glass.bsdf, BsdfKind::kDielectric);
  EXPECT_FLOAT_EQ(glass.ior, 1.33f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"dielectric\" \"float eta\" 1.7").ior, 1.7f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"").ior,
                  1.5168f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"dielectric\"").ior, 1.5f);
}

TEST(Materials, ConductorsAreRead) {
  const Material gold = OnlyMaterial(
      "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" "
      "\"float roughness\" 0.04");
  EXPECT_EQ(gold.bsdf, BsdfKind::kConductor);
  ExpectNear(gold.eta, {0.14312f, 0.37496f, 1.44248f});
  ExpectNear(gold.k, {3.98316f, 2.38572f, 1.60322f});
  EXPECT_FLOAT_EQ(gold.alpha, 0.2f);  // pbrt-v4: the square root
  const Material v3 = OnlyMaterial(
      "Material \"metal\" \"spectrum eta\" \"spds/Ag.eta.spd\" \"spectrum k\" \"spds/Ag.k.spd\" "
      "\"float roughness\" 0.1");
  ExpectNear(v3.k, {4.82834f, 3.12225f, 2.14695f});
  // 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 at x = ln 0.1
  EXPECT_NEAR(v3.alpha, 0.46176f, 1e-4f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"metal\" \"float roughness\" .3 "
                               "\"bool remaproughness\" \"false\"")
                      .alpha,
                  0.3f);
  EXPECT_FLOAT_EQ(
      OnlyMaterial("Material \"conductor\" \"float roughness\" .3 \"bool remaproughness\" false")
          .alpha,
      0.3f);
  ExpectNear(OnlyMaterial("Material \"metal\" \"rgb eta\" [1 2 3] \"rgb k\" [4 5 6]").eta,
             {1, 2, 3});
  // Smooth conductors become mirrors that keep their Fresnel reflectance.
  const Material smooth = OnlyMaterial("Material \"conductor\"");
  EXPECT_EQ(smooth.bsdf, BsdfKind::kMirror);
  ExpectNear(smooth.eta, {0.20044f, 0.92403f, 1.10221f});
  // eta = 1 and k give F = k^2 / (4 + k^2) at normal incidence.
  const glm::vec3 k =
      OnlyMaterial("Material \"conductor\" \"rgb reflectance\" [.2 .5 .8] \"float roughness\" 0.1")
          .k;
  ExpectNear(k * k / (4.0f + k * k), {0.2f, 0.5f, 0.8f});
  const Material anisotropic = OnlyMaterial(
      "Material \"conductor\" \"float uroughness\" .1 \"float vroughness\" .4 \"bool "
      "remaproughness\" "
      "false");
  EXPECT_EQ(anisotropic.bsdf, BsdfKind::kAnisotropicConductor);
  EXPECT_FLOAT_EQ(anisotropic.alpha, 0.1f);
  EXPECT_FLOAT_EQ(anisotropic.alpha_across.value(), 0.4f);
  // Metal that is rough in one direction alone is brushed.
  for (const bool along : {true, false}) {
    const Material brushed = OnlyMaterial(std::string("Material \"conductor\" \"float ") +
                                          (along ? "uroughness" : "vroughness") + "\" .09");
    EXPECT_EQ(brushed.bsdf, BsdfKind::kAnisotropicConductor);
    EXPECT_FLOAT_EQ(brushed.alpha, along ? 0.3f : 0.0f);
    EXPECT_FLOAT_EQ(brushed.alpha_across.value(), along ? 0.0f : 0.3f);
  }
  const Material coated = OnlyMaterial(
      "Material \"coatedconductor\" \"float conductor.roughness\" .25 "
      "\"float interface.roughness\" .01 \"float interface.eta\" 1.4 "
      "\"spectrum conductor.eta\" \"metal-Au-eta\" \"spectrum conductor.k\" \"metal-Au-k\"");
  EXPECT_EQ(coated.bsdf, BsdfKind::kCoatedConductor);
  EXPECT_FLOAT_EQ(coated.alpha, 0.5f);
  EXPECT_FLOAT_EQ(coated.coat_alpha, 0.1f);
  EXPECT_FLOAT_EQ(coated.ior, 1.4f);
  // The geometric mean with pbrt's least width.
  const Material brushed_coat =
      OnlyMaterial("Material \"coatedconductor\" \"float interface.vroughness\" .09");
  EXPECT_NEAR(brushed_coat.coat_alpha, std::sqrt(0.3f * 1e-4f), 1e-6f);
  ExpectNear(coated.k, {3.98316f, 2.38572f, 1.60322f});
}

// The indices n_d of Schott's catalogue, to all of its digits; F5, F10 and F11 are SF5, SF10 and
// SF11 in pbrt. An index by wavelength counts where n_d does.
TEST(Materials, NamedGlassesHaveTheirIndices) {
  const std::pair<const char*, double> glasses[] = {
      {"BK7", 1.51680},  {"BAF10", 1.67003}, {"FK51A", 1.48656}, {"LASF9", 1.85025},
      {"F5", 1.67271},   {"F10", 1.72825},   {"F11", 1.78472},   {"SF5", 1.67271},
      {"SF10", 1.72825}, {"SF11", 1.78472}};
  for (const auto& [name, index] : glasses) {
    const std::string material =
        "Material \"dielectric\" \"spectrum eta\" \"glass-" + std::string(name) + "\"";
    EXPECT_NEAR(OnlyMaterial(material).ior, index, 1e-4) << name;
  }
  const std::string glass = "Material \"dielectric\" \"spectrum eta\" ";
  EXPECT_NEAR(OnlyMaterial(glass + "[400 1.7 700 1.4]").ior, 1.7 - 0.3 * 187.6 / 300, 1e-6);
  EXPECT_NEAR(OnlyMaterial("Material \"coateddiffuse\" \"spectrum eta\" [300 1.4]").ior, 1.4, 1e-6);
  EXPECT_THROW(OnlyMaterial(glass + "[700 1.7 400 1.4]"), InputError);
  EXPECT_THROW(OnlyMaterial(glass + "[400]"), InputError);
}

// Under both of pbrt's spellings; and about the reflectances at normal incidence that are published
// for these metals (Akenine-Moeller et al. 2018, table 9.2, where gold's red is above 1).
TEST(Materials, NamedMetalsHaveTheirIndices) {
  struct Metal {
    std::string name;
    glm::vec3 eta, k, reflectance;
  };
  const Metal metals[] = {
      {"Ag", {0.15526f, 0.11672f, 0.13838f}, {4.82834f, 3.12225f, 2.14695f}, {0.97f, 0.96f, 0.92f}},
      {"Al", {1.65746f, 0.88037f, 0.52123f}, {9.22387f, 6.26952f, 4.83700f}, {0.91f, 0.92f, 0.92f}},
      {"Au", {0.14312f, 0.37496f, 1.44248f}, {3.98316f, 2.38572f, 1.60322f}, {0.97f, 0.78f, 0.34f}},
      {"Cu", {0.20044f, 0.92403f, 1.10221f}, {3.91295f, 2.45285f, 2.14219f}, {0.95f, 0.64f, 0.54f}},
      {"MgO", {1.73438f, 1.74079f, 1.75403f}, glm::vec3(0), {0.072f, 0.073f, 0.075f}},
  };
  for (const Metal& metal : metals) {
    SCOPED_TRACE(metal.name);
    const auto read = [&](const std::string& eta, const std::string& k) {
      const Material material = OnlyMaterial(
          "Material \"conductor\" \"float roughness\" 0.1 "
          "\"spectrum eta\" \"" +
          eta + "\" \"spectrum k\" \"" + k + "\"");
      ExpectNear(material.eta, metal.eta);
      ExpectNear(material.k, metal.k);
    };
    read("metal-" + metal.name + "-eta", "metal-" + metal.name + "-k");
    read("spds/" + metal.name + ".eta.spd", "spds/" + metal.name + ".k.spd");
    const glm::vec3 k2 = metal.k * metal.k, less = metal.eta - 1.0f, more = metal.eta + 1.0f;
    const glm::vec3 reflectance = (less * less + k2) / (more * more + k2);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(reflectance[c], metal.reflectance[c], 0.03);
  }
}

TEST(Materials, DiffuseMaterialsAreRead) {
  const Material clay = OnlyMaterial("Material \"matte\" \"float sigma\" 20");
  EXPECT_EQ(clay.bsdf, BsdfKind::kOrenNayar);
  // The ratio is B / A of Oren and Nayar 1994 for sigma = 20 degrees.
  EXPECT_NEAR(clay.alpha, 0.2591 / 0.8652, 1e-3);
  EXPECT_EQ(OnlyMaterial("Material \"matte\" \"float sigma\" 0").bsdf, BsdfKind::kLambert);
  const Material sheet = OnlyMaterial(
      "Material \"diffusetransmission\" \"rgb reflectance\" [.1 .2 .3] \"rgb transmittance\" "
      "[.4 .5 .6] \"float scale\" .5");
  EXPECT_EQ(sheet.bsdf, BsdfKind::kDiffuseTransmission);
  ExpectNear(sheet.reflectance, {0.05f, 0.1f, 0.15f});
  ExpectNear(sheet.second_color, {0.2f, 0.25f, 0.3f});
  const Material too_much = OnlyMaterial(
      "Material \"diffusetransmission\" \"rgb reflectance\" [1 1 1] \"rgb transmittance\" [1 1 1]");
  ExpectNear(too_much.reflectance + too_much.second_color, glm::vec3(1));
  const Material translucent = OnlyMaterial(
      "Material \"translucent\" \"rgb Kd\" [.8 .8 .8] \"rgb transmit\" [.25 .5 1] \"rgb Ks\" [0 0 "
      "0]");
  ExpectNear(translucent.second_color, {0.2f, 0.4f, 0.8f});
}

// What a file leaves out is what pbrt's own readers take, which differs between materials and
// versions.
TEST(Materials, HaveTheDefaultsOfTheirVersions) {
  // 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 at x = ln 0.1 and ln 0.01
  constexpr float kAlphaOfTenth = 0.46176f, kAlphaOfHundredth = 0.13894f;
  struct Glossy {
    const char* type;
    BsdfKind bsdf;
    float both;
    float ior;
  };
  for (const auto& [type, bsdf, both, ior] :
       {Glossy{"plastic", BsdfKind::kGlossyDiffuse, 0.25f, 1 / 1.5f},
        {"uber", BsdfKind::kGlossyDiffuse, 0.25f, 1.5f},
        {"substrate", BsdfKind::kFresnelBlend, 0.5f, 1.5f}}) {
    SCOPED_TRACE(type);
    const Material glossy = OnlyMaterial("Material \"" + std::string(type) + "\"");
    EXPECT_EQ(glossy.bsdf, bsdf);
    ExpectNear(glossy.reflectance, glm::vec3(both));
    ExpectNear(glossy.second_color, glm::vec3(both));
    EXPECT_NEAR(glossy.alpha, kAlphaOfTenth, 1e-4f);
    EXPECT_FLOAT_EQ(glossy.ior, ior);
  }
  const Material metal = OnlyMaterial("Material \"metal\"");
  EXPECT_EQ(metal.bsdf, BsdfKind::kConductor);
  EXPECT_NEAR(metal.alpha, kAlphaOfHundredth, 1e-4f);
  const Material paint = OnlyMaterial("Material \"coateddiffuse\"");
  ExpectNear(paint.reflectance, glm::vec3(0.5f));
  EXPECT_EQ(paint.alpha, 0);
  EXPECT_FLOAT_EQ(paint.ior, 1.5f);
  const Material lacquer = OnlyMaterial("Material \"coatedconductor\"");
  ExpectNear(lacquer.eta, {0.20044f, 0.92403f, 1.10221f});  // copper
  EXPECT_EQ(lacquer.alpha, 0);
  EXPECT_EQ(lacquer.coat_alpha, 0);
  EXPECT_FLOAT_EQ(lacquer.ior, 1.5f);
  const Material sheet = OnlyMaterial("Material \"diffusetransmission\"");
  ExpectNear(sheet.reflectance, glm::vec3(0.25f));
  ExpectNear(sheet.second_color, glm::vec3(0.25f));
  // A quarter of the light, of which each side gets a half.
  const Material leaf = OnlyMaterial("Material \"translucent\" \"rgb Ks\" [0 0 0]");
  ExpectNear(leaf.reflectance, glm::vec3(0.125f));
  ExpectNear(leaf.second_color, glm::vec3(0.125f));
  const Material page = OnlyMaterial(
      "Material \"translucent\" \"rgb reflect\" [.4 .2 0] \"rgb transmit\" [.1 0 .8] "
      "\"rgb Ks\" [0 0 0]");
  ExpectNear(page.reflectance, {0.1f, 0.05f, 0});
  ExpectNear(page.second_color, {0.025f, 0, 0.2f});
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"thindielectric\"").ior, 1.5f);
}

// Returns both parts of the sum that is the last material of a text.
std::array<Material, 2> PartsOf(const std::string& text) {
  const Scene scene = Parse(text);
  const Material& sum = scene.materials.back();
  EXPECT_TRUE(sum.mixture && sum.mixture->share == 0.5f) << text;
  return {scene.materials.at(sum.mixture->first), scene.materials.at(sum.mixture->second)};
}

// A hit has one of the parts, so each part has twice its colours.
TEST(PbrtMaterials, GlossOfVersion3IsReadForEitherSide) {
  const auto [body, facets] = PartsOf(
      "Material \"translucent\" \"rgb Kd\" [.8 .6 .4] \"rgb Ks\" [.4 .2 .1] \"float roughness\" .2 "
      "\"bool remaproughness\" \"false\" \"rgb reflect\" [.5 .5 1] \"rgb transmit\" [.25 .5 0]");
  EXPECT_EQ(body.bsdf, BsdfKind::kDiffuseTransmission);
  ExpectNear(body.reflectance, {0.8f, 0.6f, 0.8f});
  ExpectNear(body.second_color, {0.4f, 0.6f, 0});
  EXPECT_EQ(facets.bsdf, BsdfKind::kRoughDielectric);
  ExpectNear(facets.reflectance, {0.2f, 0.2f, 0});
  ExpectNear(facets.reflection.value(), {0.4f, 0.2f, 0.2f});
  EXPECT_FLOAT_EQ(facets.alpha, 0.2f);
  EXPECT_FALSE(facets.energy_compensation);
}

TEST(PbrtMaterials, UberIsABodyAGlossAndGlass) {
  const auto [rough, smooth] = PartsOf(
      "Material \"uber\" \"rgb Kd\" [.1 .2 .3] \"rgb Ks\" [.3 .2 .1] \"rgb Kr\" [.4 .5 .6] "
      "\"rgb Kt\" [.2 .1 0] \"float index\" 1.3");
  EXPECT_EQ(rough.bsdf, BsdfKind::kGlossyDiffuse);
  ExpectNear(rough.reflectance, {0.2f, 0.4f, 0.6f});
  ExpectNear(rough.second_color, {0.6f, 0.4f, 0.2f});
  EXPECT_EQ(smooth.bsdf, BsdfKind::kDielectric);
  ExpectNear(smooth.reflection.value(), {0.8f, 1, 1.2f});
  ExpectNear(smooth.reflectance, {0.4f, 0.2f, 0});
  EXPECT_FLOAT_EQ(rough.ior, 1.3f);
  EXPECT_FLOAT_EQ(smooth.ior, 1.3f);
  EXPECT_FLOAT_EQ(OnlyMaterial("Material \"uber\" \"rgb opacity\" [.3 .3 .3]").opacity, 0.3f);
}

TEST(Materials, RoughAndThinGlassAreRead) {
  const Material frosted =
      OnlyMaterial("Material \"dielectric\" \"float roughness\" .09 \"float eta\" 1.4");
  EXPECT_EQ(frosted.bsdf, BsdfKind::kRoughDielectric);
  EXPECT_FLOAT_EQ(frosted.alpha, 0.3f);
  EXPECT_FLOAT_EQ(frosted.ior, 1.4f);
  EXPECT_EQ(OnlyMaterial("Material \"glass\" \"float uroughness\" .1 \"float vroughness\" .1").bsdf,
            BsdfKind::kRoughDielectric);
  const Material ground =
      OnlyMaterial("Material \"dielectric\" \"float uroughness\" .04 \"float vroughness\" .25");
  EXPECT_EQ(ground.bsdf, BsdfKind::kRoughDielectric);
  EXPECT_FLOAT_EQ(ground.alpha, 0.2f);
  EXPECT_FLOAT_EQ(ground.alpha_across.value(), 0.5f);
  EXPECT_FALSE(frosted.alpha_across);
  EXPECT_EQ(OnlyMaterial("Material \"glass\" \"float roughness\" 0").bsdf, BsdfKind::kDielectric);
  // Roughness may be a texture that is constant.
  const std::string by_texture =
      "Texture \"r\" \"float\" \"constant\" \"float value\" .09\n"
      "Texture \"z\" \"float\" \"constant\" \"float value\" 0\n";
  EXPECT_FLOAT_EQ(
      OnlyMaterial(by_texture + "Material \"dielectric\" \"texture roughness\" \"r\"").alpha, 0.3f);
  for (const char* const type : {"dielectric", "glass"}) {
    const std::string glass = "Material \"" + std::string(type) + "\" \"texture roughness\" ";
    EXPECT_EQ(OnlyMaterial(by_texture + glass + "\"r\"").bsdf, BsdfKind::kRoughDielectric);
    EXPECT_EQ(OnlyMaterial(by_texture + glass + "\"z\"").bsdf, BsdfKind::kDielectric);
  }
  EXPECT_EQ(OnlyMaterial("Material \"thindielectric\" \"float eta\" 1.2").bsdf,
            BsdfKind::kThinDielectric);
}

// Version 3 gives what glass reflects and what it lets through a colour each.
TEST(PbrtMaterials, GlassOfVersion3HasTwoColours) {
  const Material stained =
      OnlyMaterial("Material \"glass\" \"rgb Kr\" [.1 .2 .3] \"rgb Kt\" [.7 .8 .9]");
  EXPECT_EQ(stained.reflectance, glm::vec3(0.7f, 0.8f, 0.9f));
  EXPECT_EQ(stained.reflection, glm::vec3(0.1f, 0.2f, 0.3f));
  const Material matt = OnlyMaterial("Material \"glass\" \"rgb Kr\" [0 0 0]");
  EXPECT_EQ(matt.reflectance, glm::vec3(1));
  EXPECT_EQ(matt.reflection, glm::vec3(0));
  EXPECT_FALSE(OnlyMaterial("Material \"glass\" \"rgb Kr\" [1 1 1]").reflection);
}

TEST(Materials, MixturesAreRead) {
  const char* const kTwo =
      "WorldBegin\nMakeNamedMaterial \"a\" \"string type\" \"matte\"\n"
      "MakeNamedMaterial \"b\" \"string type\" \"mirror\"\n";
  const auto mixture = [&](const std::string& rest) {
    const Scene scene = Parse(kTwo + ("Material \"mix\" " + rest) + "\n" + kTriangle);
    return scene.materials.at(scene.meshes.at(0).material).mixture.value();
  };
  const Mixture v4 = mixture("\"string materials\" [\"a\" \"b\"] \"float amount\" .3");
  EXPECT_EQ(v4.second, v4.first + 1);
  EXPECT_FLOAT_EQ(v4.share, 0.3f);
  const Mixture v3 = mixture(
      "\"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb amount\" [.3 .3 .3]");
  EXPECT_EQ(v3.second, v3.first + 1);
  EXPECT_FLOAT_EQ(v3.share, 0.7f);
  EXPECT_THROW(mixture("\"string materials\" [\"a\" \"c\"]"), InputError);
  EXPECT_THROW(mixture("\"string materials\" [\"a\"]"), InputError);
}

TEST(Materials, NamedMaterialsAndConstantTexturesAreRead) {
  const Scene scene = Parse(
      std::string("WorldBegin\n"
                  "Texture \"warm\" \"spectrum\" \"constant\" \"rgb value\" [.9 .5 .1]\n"
                  "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"texture Kd\" \"warm\"\n"
                  "MakeNamedMaterial \"b\" \"string type\" [\"glass\"]\n"
                  "NamedMaterial \"a\"\n") +
      kTriangle + "NamedMaterial \"b\"\n" + kTriangle);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  ExpectNear(scene.materials.at(scene.meshes.at(0).material).reflectance, {0.9f, 0.5f, 0.1f});
  EXPECT_EQ(scene.materials.at(scene.meshes.at(1).material).bsdf, BsdfKind::kDielectric);
}

// IEC 61966-2-1: half the XYZ of the white D65 is grey, and that of the red primary is red.
TEST(Materials, ColoursOfXyzAreThoseOfTheirPrimaries) {
  ExpectNear(OnlyMaterial("Material \"matte\" \"xyz Kd\" [.47525 .5 .54445]").reflectance,
             glm::vec3(0.5f), 1e-3f);
  ExpectNear(OnlyMaterial("Material \"matte\" \"xyz Kd\" [.2062 .1063 .00965]").reflectance,
             {0.5f, 0, 0}, 1e-3f);
}

}  // namespace
}  // namespace skywave
