// Tests what textures in space do to materials: roughness, mixtures and their parts.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "image/image.h"
#include "scene/geometry.h"
#include "scene/materials/noise.h"
#include "scene/pbrt/reader.h"
#include "tests/support/baked_places.h"

namespace skywave {
namespace {

// Roughness of noise is remapped as a number is, and the baked value is the root of alpha.
TEST(SolidTextures, MakeRoughness) {
  const Scene scene = Parse(
      "Texture \"n\" \"float\" \"wrinkled\" \"integer octaves\" 2 Material \"conductor\" "
      "\"texture roughness\" \"n\" Shape \"sphere\"");
  ASSERT_TRUE(scene.warnings.empty()) << scene.warnings[0];
  const Material& material = scene.materials[scene.meshes[0].material];
  EXPECT_EQ(material.bsdf, BsdfKind::kConductor);
  EXPECT_EQ(material.alpha, 1);
  for (const Place& p : Places(scene, 1, &Material::roughness_texture)) {
    const glm::dvec3 at(p.position);
    const double sum =
        std::abs(GradientNoise(at)) + 0.5 * std::abs(GradientNoise(1.99 * at)) + 0.2 * 0.25;
    // pbrt-v4 takes the root of roughness for alpha.
    ASSERT_NEAR(std::pow(double(p.color.y), 4), Clamped(sum), 0.04);
  }
}

// Versions 3 and 4 mean shares of the first and of the second material.
TEST(SolidTextures, MixMaterials) {
  const std::string checks =
      "Texture \"c\" \"float\" \"checkerboard\" \"integer dimension\" 3 \"float tex1\" .8 \"float "
      "tex2\" .1 MakeNamedMaterial \"p\" \"string type\" \"matte\" MakeNamedMaterial \"q\" "
      "\"string "
      "type\" \"mirror\" Material \"mix\" \"texture amount\" \"c\" ";
  for (const bool v4 : {false, true}) {
    const Scene scene =
        Parse(checks +
              (v4 ? "\"string materials\" [\"p\" \"q\"]"
                  : "\"string namedmaterial1\" \"p\" \"string namedmaterial2\" \"q\"") +
              " Shape \"trianglemesh\" \"point3 P\" [-1 -1 .3 1 -1 .2 1 1 .9]");
    ASSERT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    for (const Place& place : Places(scene, 500, &Material::mixture_texture)) {
      const glm::vec3 to_edge = glm::abs(place.position - glm::round(place.position));
      if (std::min({to_edge.x, to_edge.y, to_edge.z}) < 0.02f) continue;
      const glm::ivec3 cell(glm::floor(place.position));
      const float amount = (cell.x + cell.y + cell.z) % 2 == 0 ? .8f : .1f;
      ASSERT_NEAR(place.color.x, v4 ? amount : 1 - amount, 1e-5f);
    }
  }
}

// The parts of a mixture, and those of a mixture in it, have images of their own over one (u, v).
TEST(SolidTextures, VaryInThePartsOfMixtures) {
  const Scene scene = Parse(
      "Texture \"c\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 \"rgb tex1\" [.8 .1 .1] "
      "\"rgb tex2\" [.1 .2 .7] Texture \"n\" \"float\" \"wrinkled\" \"integer octaves\" 1 "
      "MakeNamedMaterial \"p\" \"string type\" \"diffuse\" \"texture reflectance\" \"c\" "
      "MakeNamedMaterial \"q\" \"string type\" \"conductor\" \"texture roughness\" \"n\" "
      "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"p\" \"q\"] "
      "Material \"mix\" \"string materials\" [\"q\" \"m\"] "
      "Shape \"trianglemesh\" \"point3 P\" [-1 -1 .3 1 -1 .2 1 1 .9] \"float alpha\" .5");
  ASSERT_TRUE(scene.warnings.empty()) << scene.warnings[0];
  Scene part = scene;
  std::uint32_t& material = part.meshes[0].material;
  EXPECT_EQ(part.materials[material].opacity, 0.5f);
  const auto noise = [](const Place& p) {
    const glm::dvec3 at(p.position);
    return Clamped(std::abs(GradientNoise(at)) + 0.2 * 0.5);
  };
  const Mixture outer = *part.materials[material].mixture;
  material = outer.first;
  for (const Place& p : Places(part, 200, &Material::roughness_texture)) {
    ASSERT_NEAR(std::pow(double(p.color.y), 4), noise(p), 0.04);
  }
  const Mixture inner = *part.materials[outer.second].mixture;
  material = inner.first;
  for (const Place& p : Places(part, 200)) {
    const glm::vec3 to_edge = glm::abs(p.position - glm::round(p.position));
    if (std::min({to_edge.x, to_edge.y, to_edge.z}) < 0.02f) continue;
    const glm::ivec3 cell(glm::floor(p.position));
    ASSERT_NEAR(p.color.x, (cell.x + cell.y + cell.z) % 2 == 0 ? .8f : .1f, 1e-5f);
  }
  material = inner.second;
  for (const Place& p : Places(part, 200, &Material::roughness_texture)) {
    ASSERT_NEAR(std::pow(double(p.color.y), 4), noise(p), 0.04);
  }
}

// Returns a file that names a material "m" and then 40 times the mixture of it with itself so.
std::string DeepMixture(const std::string& material) {
  std::string text = "MakeNamedMaterial \"m\" \"string type\" \"diffuse\" " + material + "\n";
  for (int i = 0; i < 40; ++i) {
    text +=
        "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"m\" "
        "\"m\"]\n";
  }
  return text;
}

// There is one copy of each part, not 2^40.
TEST(SolidTextures, MixturesShareTheirParts) {
  const Scene scene =
      ParseAll("Texture \"c\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3 " +
               DeepMixture("\"texture reflectance\" \"c\"") +
               "NamedMaterial \"m\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]");
  std::uint32_t material = scene.meshes.at(0).material;
  while (scene.materials[material].mixture) {
    const Mixture& mixture = *scene.materials[material].mixture;
    ASSERT_EQ(mixture.first, mixture.second);
    material = mixture.first;
  }
  EXPECT_TRUE(scene.materials[material].color_texture.has_value());
  EXPECT_EQ(scene.images.size(), 1u);
}

// The search for textures and for normal maps must not take 2^40 steps either.
TEST(SolidTextures, DeepMixturesOfOthersAreRead) {
  const Scene scene = ParsePbrt("WorldBegin " + DeepMixture("") +
                                    "ObjectBegin \"o\" NamedMaterial \"m\" Shape \"sphere\" "
                                    "ObjectEnd ObjectInstance \"o\" ObjectInstance \"o\"",
                                "t.pbrt", {.instances = InstanceUse::kShare});
  EXPECT_EQ(scene.objects.at(0).meshes.size(), 1u);
  EXPECT_THROW(Geometry(scene, "t.pbrt"), InputError);
}

// As in pbrt, uroughness and vroughness override roughness, also one in space.
TEST(SolidTextures, RoughnessAlongAxesReplacesThatInSpace) {
  const Scene scene = Parse(
      "Texture \"n\" \"float\" \"wrinkled\" Material \"conductor\" \"texture roughness\" \"n\" "
      "\"float uroughness\" .25 \"float vroughness\" .25 Shape \"sphere\"");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& material = scene.materials[scene.meshes.at(0).material];
  EXPECT_FALSE(material.roughness_texture);
  EXPECT_NEAR(material.alpha, 0.5f, 1e-6f);
}

// Roots of two alphas lie in one image: along u in green, along v or of a coat in red.
TEST(SolidTextures, MakeTwoWidths) {
  const std::string noise = "Texture \"n\" \"float\" \"wrinkled\" \"integer octaves\" 2 ";
  const struct {
    const char* material;
    bool across;  // the noise is the second width, and .25 is the first
    BsdfKind bsdf;
  } cases[] = {{"\"conductor\" \"texture uroughness\" \"n\" \"float vroughness\" .25", false,
                BsdfKind::kAnisotropicConductor},
               {"\"dielectric\" \"float uroughness\" .25 \"texture vroughness\" \"n\"", true,
                BsdfKind::kRoughDielectric},
               {"\"coatedconductor\" \"float conductor.roughness\" .25 "
                "\"texture interface.roughness\" \"n\"",
                true, BsdfKind::kCoatedConductor},
               {"\"coatedconductor\" \"texture conductor.roughness\" \"n\" "
                "\"float interface.roughness\" .25",
                false, BsdfKind::kCoatedConductor}};
  for (const auto& test : cases) {
    SCOPED_TRACE(test.material);
    const Scene scene = Parse(noise + "Material " + test.material + " Shape \"sphere\"");
    ASSERT_EQ(scene.warnings, std::vector<std::string>{});
    const Material& material = scene.materials[scene.meshes.at(0).material];
    EXPECT_EQ(material.bsdf, test.bsdf);
    EXPECT_EQ(material.alpha, 1);
    const bool coat = test.bsdf == BsdfKind::kCoatedConductor;
    EXPECT_EQ(coat ? material.coat_alpha : material.alpha_across.value_or(0), 1);
    for (const Place& p : Places(scene, 200, &Material::roughness_texture)) {
      const glm::dvec3 at(p.position);
      const double sum =
          std::abs(GradientNoise(at)) + 0.5 * std::abs(GradientNoise(1.99 * at)) + 0.2 * 0.25;
      const float varied = test.across ? p.color.x : p.color.y;
      const float constant = test.across ? p.color.y : p.color.x;
      ASSERT_NEAR(std::pow(double(varied), 4), Clamped(sum), 0.04);
      ASSERT_NEAR(constant, std::sqrt(0.5), 1e-3);
    }
  }
}

// A surface between equal indices stays smooth, and needs no image.
TEST(SolidTextures, SmoothSurfacesNeedNoRoughness) {
  const std::string noise = "Texture \"n\" \"float\" \"wrinkled\" Material \"dielectric\" ";
  const std::string rough = " \"texture roughness\" \"n\" Shape \"sphere\"";
  EXPECT_EQ(Parse(noise + "\"float eta\" 1.5" + rough).images.size(), 1u);
  const Scene smooth = Parse(noise + "\"float eta\" 1" + rough);
  EXPECT_TRUE(smooth.images.empty());
  const Material& material = smooth.materials[smooth.meshes.at(0).material];
  EXPECT_EQ(material.bsdf, BsdfKind::kDielectric);
  EXPECT_FALSE(material.roughness_texture);
}

}  // namespace
}  // namespace skywave
