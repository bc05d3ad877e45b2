// Tests the layers of glTF's materials: coats, sheen, specular, anisotropy, iridescence, unlit.
#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "image/image.h"
#include "kernels/surface/surface.h"
#include "scene/geometry.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

TEST_F(Gltf, CoatSheenAndSpecularAreRead) {
  json document = Document();
  json& extensions = document["materials"][0]["extensions"];
  extensions["KHR_materials_clearcoat"] = {{"clearcoatFactor", 0.5},
                                           {"clearcoatRoughnessFactor", 0.3}};
  const Material coated = Read(document).materials[0];
  EXPECT_EQ(coated.bsdf, BsdfKind::kCoatedMetallicRoughness);
  EXPECT_FLOAT_EQ(coated.coat, 0.5f);
  EXPECT_FLOAT_EQ(coated.coat_alpha, 0.09f);
  EXPECT_EQ(coated.sheen, glm::vec3(0));
  WritePng(folder_.Write("n.png", ""), 1, 1, {128, 128, 255});
  document["images"] = {{{"uri", "n.png"}}};
  document["textures"] = {{{"source", 0}}};
  document["materials"][0]["normalTexture"] = {{"index", 0}};
  extensions["KHR_materials_clearcoat"]["clearcoatNormalTexture"] = {{"index", 0}};
  EXPECT_EQ(Body(Read(document)).bsdf, BsdfKind::kCoatedMetallicRoughness) << "the same normals";
  EXPECT_TRUE(Read(document).warnings.empty());
  // A texture of its strength, here of one value.
  extensions["KHR_materials_clearcoat"]["clearcoatTexture"] = {{"index", 0}};
  EXPECT_FLOAT_EQ(Body(Read(document)).coat, 0.5f * 128 / 255);
  EXPECT_TRUE(Read(document).warnings.empty());
  WritePng(folder_.Write("n.png", ""), 2, 1, {128, 128, 255, 0, 128, 255});
  const Scene partly = Read(document);
  ASSERT_TRUE(Body(partly).mixture);
  EXPECT_EQ(partly.materials[Body(partly).mixture->first].bsdf, BsdfKind::kMetallicRoughness);
  EXPECT_EQ(partly.materials[Body(partly).mixture->second].coat, 1);
  const auto& shares = partly.textures.at(Body(partly).mixture_texture.value());
  EXPECT_FLOAT_EQ(partly.images[shares.image].Floats().rgb[0], 0.5f * 128 / 255);
  extensions["KHR_materials_clearcoat"] = {{"clearcoatFactor", 0}};
  EXPECT_EQ(Read(document).materials[0].bsdf, BsdfKind::kMetallicRoughness);
  extensions["KHR_materials_sheen"] = {{"sheenColorFactor", {0.1, 0.2, 0.3}},
                                       {"sheenRoughnessFactor", 0.5}};
  const Material velvet = Read(document).materials[0];
  EXPECT_EQ(velvet.bsdf, BsdfKind::kCoatedMetallicRoughness);
  EXPECT_EQ(velvet.coat, 0);
  EXPECT_EQ(velvet.sheen, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_FLOAT_EQ(velvet.sheen_alpha, 0.25f);
  EXPECT_EQ(Read(document).warnings, std::vector<std::string>{});
}

// Where a coat has other normals than its base, they are those of the surface, and the base has its
// own.
TEST_F(Gltf, CoatsHaveNormalsOfTheirOwn) {
  json document = Document();
  WritePng(folder_.Write("n.png", ""), 1, 1, {128, 128, 255});
  document["images"] = {{{"uri", "n.png"}}};
  document["textures"] = {{{"source", 0}}};
  json& material = document["materials"][0];
  json& coat = material["extensions"]["KHR_materials_clearcoat"];
  coat = {{"clearcoatFactor", 1}};
  const auto expect = [&](const Material& is, bool of_coat, float scale, bool of_base,
                          float base_scale) {
    EXPECT_EQ(is.bsdf, BsdfKind::kLayeredMetallicRoughness);
    EXPECT_TRUE(is.own_base_normals);
    EXPECT_EQ(is.normal_texture.has_value(), of_coat);
    EXPECT_EQ(is.normal_scale, scale);
    EXPECT_EQ(is.base_normal_texture.has_value(), of_base);
    EXPECT_EQ(is.base_normal_scale, base_scale);
  };
  coat["clearcoatNormalTexture"] = {{"index", 0}, {"scale", 0.5}};
  expect(Body(Read(document)), true, 0.5f, false, 1);
  material["normalTexture"] = {{"index", 0}, {"scale", 2}};
  expect(Body(Read(document)), true, 0.5f, true, 2);
  coat["clearcoatNormalTexture"]["scale"] = 2;
  EXPECT_FALSE(Body(Read(document)).own_base_normals) << "the same normals";
  coat["clearcoatNormalTexture"]["extensions"]["KHR_texture_transform"] = {{"offset", {0.5, 0}}};
  expect(Body(Read(document)), true, 2, true, 2);
  coat.erase("clearcoatNormalTexture");
  expect(Body(Read(document)), false, 1, true, 2);
  // A map that cannot be read is none, and said.
  coat["clearcoatNormalTexture"] = {{"index", 0}};
  material.erase("normalTexture");
  document["images"][0]["uri"] = "missing.png";
  const Scene broken = Read(document);
  EXPECT_FALSE(Body(broken).own_base_normals);
  EXPECT_NE(broken.warnings.at(0).find("missing.png"), std::string::npos);
}

// An unlit surface has the radiance of its base colour and reflects nothing; radiance has no
// colours of vertices, so with these it is lit, which is said.
TEST_F(Gltf, UnlitMaterialsShineInTheirBaseColour) {
  WritePng(folder_.Write("t.png", ""), 1, 1, {255, 128, 51});
  json document = Document();
  document["images"] = {{{"uri", "t.png"}}};
  document["textures"] = {{{"source", 0}}};
  json& material = document["materials"][0];
  material["extensions"] = {{"KHR_materials_unlit", json::object()}};
  material["pbrMetallicRoughness"] = {{"baseColorFactor", {0.5, 0.25, 1, 1}},
                                      {"baseColorTexture", {{"index", 0}}}};
  material["emissiveFactor"] = {1, 1, 1};
  material["doubleSided"] = true;
  const Scene scene = Read(document);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  EXPECT_EQ(Body(scene).reflectance, glm::vec3(0));
  EXPECT_EQ(Body(scene).emission, glm::vec3(0.5f, 0.25f, 1)) << "not that of what is lit";
  EXPECT_TRUE(Body(scene).emission_texture);
  EXPECT_TRUE(Body(scene).emits_on_both_sides);
  json& primitives = document["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[1]["attributes"]["COLOR_0"] = primitives[1]["attributes"]["POSITION"];
  const Scene both = Read(document);
  EXPECT_EQ(both.materials[both.meshes.front().material].reflectance, glm::vec3(0));
  const Material& tinted = both.materials[both.meshes.back().material];
  EXPECT_EQ(tinted.reflectance, glm::vec3(0.5f, 0.25f, 1));
  EXPECT_EQ(tinted.emission, glm::vec3(0));
  EXPECT_NE(both.warnings.at(0).find("unlit with colours of vertices"), std::string::npos);
}

// The texture of every test below: red 255, 0; green 128, 64; blue 51, 204.
class GltfLayers : public Gltf {
 protected:
  // Reads the document with these extensions of its material.
  Scene ReadWith(const json& extensions) {
    WritePng(folder_.Write("t.png", ""), 2, 1, {255, 128, 51, 0, 64, 204});
    json document = Document();
    document["images"] = {{{"uri", "t.png"}}};
    document["textures"] = {{{"source", 0}}};
    document["materials"][0]["extensions"] = extensions;
    return Read(document);
  }
  static float Red(const Scene& scene, std::optional<std::uint32_t> texture) {
    return scene.images[scene.textures.at(texture.value()).image].Floats().rgb[0];
  }
  const json texture_ = {{"index", 0}};
};

// Each layer is read with its textures, in the channels that its extension names.
TEST_F(GltfLayers, SpecularHasItsFactorsAndTextures) {
  const Scene scene = ReadWith({{"KHR_materials_specular",
                                 {{"specularFactor", 0.25},
                                  {"specularColorFactor", {0.5, 1, 2}},
                                  {"specularTexture", texture_},
                                  {"specularColorTexture", texture_}}}});
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& shiny = Body(scene);
  EXPECT_EQ(shiny.bsdf, BsdfKind::kLayeredMetallicRoughness);
  EXPECT_EQ(shiny.specular, 0.25f);
  EXPECT_EQ(shiny.specular_color, glm::vec3(0.5f, 1, 2));
  EXPECT_EQ(Red(scene, shiny.specular_texture), 1) << "a picture without alpha is opaque";
  EXPECT_EQ(Red(scene, shiny.specular_color_texture), 1);
  EXPECT_EQ(shiny.coat, 0);
}

TEST_F(GltfLayers, GrainsHaveTheirFactorsAndTexture) {
  const Scene scene = ReadWith({{"KHR_materials_anisotropy",
                                 {{"anisotropyStrength", 0.5},
                                  {"anisotropyRotation", 0.75},
                                  {"anisotropyTexture", texture_}}}});
  EXPECT_EQ(Body(scene).bsdf, BsdfKind::kLayeredMetallicRoughness);
  EXPECT_EQ(Body(scene).anisotropy, 0.5f);
  EXPECT_EQ(Body(scene).anisotropy_turn, 0.75f);
  EXPECT_TRUE(Body(scene).anisotropy_texture);
}

// A grain follows tangents, or else texture coordinates; a mesh without both has it along an axis
// that no file asks for.
TEST_F(GltfLayers, GrainsWithoutADirectionAreNamed) {
  json document = Document();
  document["materials"][0]["extensions"] = {
      {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}}};
  EXPECT_EQ(Read(document).warnings, std::vector<std::string>{});
  document["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
  const std::vector<std::string> warnings = Read(document).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("no tangents and no texture coordinates"), std::string::npos);
}

// A grain lies along the first coordinates of a mesh: those of the normal map, or else of its own
// texture, whichever textures are read before them.
TEST_F(GltfLayers, GrainsLieAlongTheCoordinatesOfTheirTexture) {
  WritePng(folder_.Write("t.png", ""), 2, 1, {255, 128, 51, 0, 64, 204});
  json document = Document();
  document["images"] = {{{"uri", "t.png"}}};
  document["textures"] = {{{"source", 0}}};
  json& attributes = document["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"];
  json& material = document["materials"][0];
  material["pbrMetallicRoughness"]["baseColorTexture"] = texture_;
  const auto set_of_color = [&] {
    const Scene scene = Read(document);
    return scene.textures.at(Body(scene).color_texture.value()).uv_set;
  };
  EXPECT_EQ(set_of_color(), UvSet::kFirst);
  const json second = {{"index", 0}, {"texCoord", 1}};
  material["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 0.5},
                                                        {"anisotropyTexture", second}};
  EXPECT_EQ(set_of_color(), UvSet::kSecond);
  material["normalTexture"] = texture_;
  EXPECT_EQ(set_of_color(), UvSet::kFirst);
  material["normalTexture"] = second;
  EXPECT_EQ(set_of_color(), UvSet::kSecond);
  material.erase("extensions");
  EXPECT_EQ(set_of_color(), UvSet::kFirst) << "normals know their own coordinates";
}

// The second axis of images, from which a grain turns away, is that of the file's tangents, or else
// of its texture coordinates, whose v grows downwards.
TEST_F(GltfLayers, GrainsKnowWhereImagesAreMirrored) {
  Scene scene = ReadWith({{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}}});
  const auto mirrored = [&] {
    return (Geometry(scene, "test", 1).tangents()[0] & kMirroredTangent) != 0;
  };
  EXPECT_TRUE(mirrored()) << "v grows upwards";
  for (Mesh& mesh : scene.meshes) {
    for (glm::vec2& uv : mesh.uvs) uv.y = -uv.y;
  }
  EXPECT_FALSE(mirrored());
  for (const float side : {-1.0f, 1.0f}) {
    for (Mesh& mesh : scene.meshes) mesh.tangents.assign(3, {1, 0, 0, side});
    EXPECT_EQ(mirrored(), side < 0);
  }
}

TEST_F(GltfLayers, FilmsHaveTheirFactorsAndTextures) {
  json film = {{"iridescenceFactor", 0.5},           {"iridescenceIor", 1.8},
               {"iridescenceThicknessMinimum", 200}, {"iridescenceThicknessMaximum", 500},
               {"iridescenceTexture", texture_},     {"iridescenceThicknessTexture", texture_}};
  const Scene scene = ReadWith({{"KHR_materials_iridescence", film}});
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  EXPECT_EQ(Body(scene).bsdf, BsdfKind::kLayeredMetallicRoughness);
  EXPECT_EQ(Body(scene).film_ior, 1.8f);
  EXPECT_EQ(Body(scene).film_thin, 200);
  EXPECT_EQ(Body(scene).film_thick, 500);
  EXPECT_EQ(Red(scene, Body(scene).film_texture), 0.5f) << "times its factor";
  EXPECT_TRUE(Body(scene).film_thickness_texture);

  film["iridescenceThicknessMaximum"] = -5, film["iridescenceIor"] = 0.5;
  const std::string said =
      fmt::format("{}", fmt::join(ReadWith({{"KHR_materials_iridescence", film}}).warnings, "\n"));
  EXPECT_NE(said.find("iridescenceThicknessMaximum -5"), std::string::npos) << said;
  EXPECT_NE(said.find("iridescenceIor 0.5 is below 1"), std::string::npos) << said;
}

TEST_F(GltfLayers, SheensAndCoatsHaveTheirTextures) {
  const Scene scene = ReadWith({{"KHR_materials_sheen",
                                 {{"sheenColorFactor", {1, 1, 1}},
                                  {"sheenRoughnessFactor", 1},
                                  {"sheenColorTexture", texture_},
                                  {"sheenRoughnessTexture", texture_}}},
                                {"KHR_materials_clearcoat",
                                 {{"clearcoatFactor", 1},
                                  {"clearcoatRoughnessFactor", 0.5},
                                  {"clearcoatRoughnessTexture", texture_}}}});
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& cloth = Body(scene);
  EXPECT_EQ(cloth.bsdf, BsdfKind::kLayeredMetallicRoughness);
  EXPECT_TRUE(cloth.sheen_texture && cloth.sheen_alpha_texture && cloth.coat_alpha_texture);
  EXPECT_EQ(cloth.coat_alpha, 0.25f);
}

TEST_F(GltfLayers, FactorsThatChangeNothingLeaveTheSimplerMaterial) {
  const Scene scene = ReadWith({{"KHR_materials_specular", {{"specularFactor", 1}}},
                                {"KHR_materials_iridescence", {{"iridescenceFactor", 0}}},
                                {"KHR_materials_anisotropy", {{"anisotropyTexture", texture_}}}});
  EXPECT_EQ(Body(scene).bsdf, BsdfKind::kMetallicRoughness);
}

TEST_F(GltfLayers, GlassHasItsColourAndItsFilm) {
  const json film = {{"iridescenceFactor", 0.75},
                     {"iridescenceIor", 1.5},
                     {"iridescenceTexture", texture_},
                     {"iridescenceThicknessTexture", texture_}};
  for (const double thickness : {0.0, 1.0}) {
    const Scene scene = ReadWith({{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                                  {"KHR_materials_volume", {{"thicknessFactor", thickness}}},
                                  {"KHR_materials_specular", {{"specularFactor", 0.25}}},
                                  {"KHR_materials_iridescence", film}});
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.at(0);
    const BsdfKind kind =
        thickness > 0 ? BsdfKind::kRoughDielectric : BsdfKind::kRoughThinDielectric;
    const auto glass = std::find_if(scene.materials.begin(), scene.materials.end(),
                                    [&](const Material& part) { return part.bsdf == kind; });
    ASSERT_NE(glass, scene.materials.end());
    EXPECT_EQ(glass->specular, 0.25f);
    EXPECT_EQ(glass->film_ior, 1.5f);
    EXPECT_EQ(Red(scene, glass->film_texture), 0.75f) << "times its factor";
    EXPECT_TRUE(glass->film_thickness_texture);
  }
}

// libFuzzer found the conversion of such an index to int.
TEST_F(GltfLayers, IndicesThatNoIntHoldsAreThoseOfMissingThings) {
  const Scene scene = ReadWith(
      {{"KHR_materials_specular", {{"specularTexture", {{"index", 1e87}, {"texCoord", 1e87}}}}}});
  const std::string said = fmt::format("{}", fmt::join(scene.warnings, "\n"));
  EXPECT_NE(said.find("there is no texture 2147483647"), said.npos) << said;
}

TEST_F(GltfLayers, GlassHasItsCoat) {
  const auto part_of = [](const Scene& scene, BsdfKind kind) {
    const auto at = std::find_if(scene.materials.begin(), scene.materials.end(),
                                 [&](const Material& part) { return part.bsdf == kind; });
    return at == scene.materials.end() ? std::nullopt : std::optional(*at);
  };
  json coat = {{"clearcoatFactor", 0.5}, {"clearcoatRoughnessFactor", 0.5}};
  for (const double thickness : {0.0, 1.0}) {
    const auto read = [&](double ior) {
      return ReadWith({{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                       {"KHR_materials_volume", {{"thicknessFactor", thickness}}},
                       {"KHR_materials_ior", {{"ior", ior}}},
                       {"KHR_materials_clearcoat", coat}});
    };
    const BsdfKind kind =
        thickness > 0 ? BsdfKind::kCoatedRoughDielectric : BsdfKind::kCoatedRoughThinDielectric;
    coat.erase("clearcoatRoughnessTexture"), coat.erase("clearcoatTexture");
    Scene scene = read(1.5);
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.at(0);
    const auto glass = part_of(scene, kind);
    ASSERT_TRUE(glass);
    EXPECT_EQ(glass->coat, 0.5f);
    EXPECT_EQ(glass->coat_alpha, 0.25f);

    coat["clearcoatTexture"] = texture_, coat["clearcoatRoughnessTexture"] = texture_;
    scene = read(1.5);
    ASSERT_TRUE(part_of(scene, kind)) << "in a mixture";
    EXPECT_FALSE(part_of(scene, kind)->coat_alpha_texture);
    EXPECT_TRUE(part_of(
        scene, thickness > 0 ? BsdfKind::kRoughDielectric : BsdfKind::kRoughThinDielectric));
    std::string said = fmt::format("{}", fmt::join(scene.warnings, "\n"));
    EXPECT_NE(said.find("the coat of what transmits has the factor alone"), said.npos) << said;

    scene = read(1);
    said = fmt::format("{}", fmt::join(scene.warnings, "\n"));
    const bool refused = said.find("the index of air has no coat") != said.npos;
    EXPECT_EQ(refused, thickness > 0) << said;
    EXPECT_EQ(part_of(scene, kind).has_value(), thickness == 0);
  }
}

TEST_F(GltfLayers, DiffuseTransmissionHasNeitherWhichIsSaid) {
  const Scene scene =
      ReadWith({{"KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", 1}}},
                {"KHR_materials_specular", {{"specularFactor", 0.5}}},
                {"KHR_materials_iridescence", {{"iridescenceFactor", 1}}}});
  const std::string said = fmt::format("{}", fmt::join(scene.warnings, "\n"));
  EXPECT_NE(said.find("diffusely is rendered without its colour"), std::string::npos) << said;
  EXPECT_NE(said.find("diffusely is rendered without the film"), std::string::npos) << said;
}

}  // namespace
}  // namespace skywave
