// Tests the materials of glTF files: textures, alpha, normal maps, colours of vertices, extensions.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "image/image.h"
#include "scene/geometry.h"
#include "tests/support/gltf_document.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

TEST_F(Gltf, TexturesHaveSamplersAndTransforms) {
  WritePng(folder_.Write("a b.png", ""), 2, 1, {255, 0, 0, 0, 255, 0});
  json document = Document();
  document["images"] = {{{"uri", "a%20b.png"}}};
  document["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
  document["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 0}}};
  json& pbr = document["materials"][0]["pbrMetallicRoughness"];
  pbr["baseColorTexture"] = {
      {"index", 0},
      {"extensions",
       {{"KHR_texture_transform",
         {{"offset", {0.25, 0.5}}, {"scale", {2, 3}}, {"rotation", 1.5707963267948966}}}}}};
  pbr["metallicRoughnessTexture"] = {{"index", 1}};
  const Scene scene = Read(document);
  const Material& paint = scene.materials[0];
  ASSERT_TRUE(paint.color_texture && paint.roughness_texture);
  const Texture& color = scene.textures[*paint.color_texture];
  EXPECT_EQ(color.wrap_u, TextureWrap::kClamp);
  EXPECT_EQ(color.wrap_v, TextureWrap::kMirror);
  // A quarter turn maps (u, v) to (3 v, -2 u) and then moves it.
  const glm::vec2 at = color.transform * glm::vec3(1, 10, 1);
  EXPECT_NEAR(at.x, 30.25, 1e-5);
  EXPECT_NEAR(at.y, -1.5, 1e-5);
  EXPECT_EQ(scene.textures[*paint.roughness_texture].wrap_u, TextureWrap::kRepeat);
  EXPECT_EQ(scene.images[color.image].Floats().rgb, (std::vector<float>{1, 0, 0, 0, 1, 0}));
  EXPECT_EQ(scene.images.size(), 2u) << "once as colours, once as numbers";
}

// Colours are encoded as sRGB, numbers and normals are not (glTF 2.0, 3.9.2 and 3.9.3).
TEST_F(Gltf, TexturesAreEncodedAsTheirUseSays) {
  WritePng(folder_.Write("a.png", ""), 1, 1, {128, 64, 255});
  json document = Document();
  document["images"] = {{{"uri", "a.png"}}};
  document["textures"] = {{{"source", 0}}};
  json& material = document["materials"][0];
  material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {{"index", 0}};
  material["normalTexture"] = {{"index", 0}};
  material["emissiveFactor"] = {1, 1, 1};
  material["emissiveTexture"] = {{"index", 0}};
  const Scene scene = Read(document);
  const Material& paint = scene.materials[0];
  const auto seen = [&](const std::optional<std::uint32_t>& texture) {
    const std::vector<float> rgb =
        scene.images[scene.textures.at(texture.value()).image].Floats().rgb;
    return glm::vec3(rgb[0], rgb[1], rgb[2]);
  };
  const glm::vec3 decoded(0.2158605f, 0.0512695f, 1), plain(128 / 255.0f, 64 / 255.0f, 1);
  ExpectNear(seen(paint.color_texture), decoded);
  ExpectNear(seen(paint.emission_texture), decoded);
  ExpectNear(seen(paint.roughness_texture), plain);
  ExpectNear(seen(paint.normal_texture), plain);
}

// The extension's own example selects the lower left quadrant of the image.
TEST_F(Gltf, TransformsTurnAsTheExtensionSays) {
  WritePng(folder_.Write("a.png", ""), 1, 1, {255, 0, 0});
  json document = Document();
  document["images"] = {{{"uri", "a.png"}}};
  document["textures"] = {{{"source", 0}}};
  document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index", 0},
      {"extensions",
       {{"KHR_texture_transform",
         {{"offset", {0, 1}}, {"scale", {0.5, 0.5}}, {"rotation", 1.57079632679}}}}}};
  const Scene scene = Read(document);
  const Texture& texture = scene.textures[*scene.materials[0].color_texture];
  for (const glm::vec2& uv : {glm::vec2(0.1f, 0.1f), {0.9f, 0.1f}, {0.1f, 0.9f}, {0.9f, 0.9f}}) {
    const glm::vec2 at = texture.transform * glm::vec3(uv, 1);
    EXPECT_TRUE(at.x > 0 && at.x < 0.5f && at.y > 0.5f && at.y < 1) << at.x << " " << at.y;
  }
  // The rotation is counter-clockwise on an image whose v points down: the right side moves to the
  // top.
  EXPECT_LT((texture.transform * glm::vec3(0.9f, 0, 1)).y,
            (texture.transform * glm::vec3(0.1f, 0, 1)).y);
}

// Returns a PNG of 2 x 1 pixels with alpha 255 and 51.
std::string TransparentPng() {
  static const unsigned char kBytes[] = {
      0x89, 'P',  'N',  'G',  0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
      0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x08, 0x06, 0x00, 0x00, 0x00, 0xf4,
      0x22, 0x7f, 0x8a, 0x00, 0x00, 0x00, 0x0f, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8,
      0xcf, 0xc0, 0xf0, 0x1f, 0x08, 0x8d, 0x01, 0x10, 0x2c, 0x03, 0x31, 0x07, 0x28, 0xa2, 0x63,
      0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  return {reinterpret_cast<const char*>(kBytes), sizeof kBytes};
}

TEST_F(Gltf, AlphaIsThatOfFactorAndTexture) {
  folder_.Write("a.png", TransparentPng());
  json document = Document();
  json& material = document["materials"][0];
  json& pbr = material["pbrMetallicRoughness"];
  pbr["baseColorFactor"] = {1, 1, 1, 0.5};
  EXPECT_TRUE(Read(document).materials[0].opaque()) << "alphaMode OPAQUE";
  material["alphaMode"] = "BLEND";
  EXPECT_EQ(Read(document).materials[0].opacity, 0.5f);
  EXPECT_FALSE(Read(document).materials[0].opacity_texture);
  material["alphaMode"] = "MASK";
  EXPECT_EQ(Read(document).materials[0].opacity, 0.5f);
  EXPECT_EQ(Read(document).materials[0].opacity_cutoff, 0.5f) << "the default";
  material["alphaCutoff"] = 0.6;
  EXPECT_EQ(Read(document).materials[0].opacity, 0);
  document["images"] = {{{"uri", "a.png"}}};
  document["textures"] = {{{"source", 0}}};
  pbr["baseColorTexture"] = {{"index", 0}};
  const Scene scene = Read(document);
  const Material& paint = scene.materials[0];
  EXPECT_EQ(paint.opacity, 0.5f);
  EXPECT_EQ(paint.opacity_cutoff, 0.6f);
  ASSERT_TRUE(paint.opacity_texture);
  const Texture& texture = scene.textures[*paint.opacity_texture];
  EXPECT_EQ(texture.use, TextureUse::kOpacity);
  EXPECT_EQ(scene.images[texture.image].Floats().rgb,
            (std::vector<float>{1, 1, 1, 0.2f, 0.2f, 0.2f}));
  EXPECT_TRUE(scene.warnings.empty());
}

// What transmits has to be seen from inside, too.
TEST_F(Gltf, MaterialsHaveOneSideUnlessTheySayOtherwiseOrTransmit) {
  json document = Document();
  json& material = document["materials"][0];
  material.erase("doubleSided");
  EXPECT_TRUE(Read(document).materials[0].one_sided);
  material["extensions"] = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}};
  EXPECT_FALSE(Read(document).materials[0].one_sided);
  material.erase("extensions");
  material["doubleSided"] = true;
  EXPECT_FALSE(Read(document).materials[0].one_sided);
  document["meshes"][0]["primitives"][0].erase("material");
  EXPECT_TRUE(Read(document).materials[0].one_sided) << "the default material";
}

TEST_F(Gltf, NormalMapsHaveTheirScaleAndTangents) {
  WritePng(folder_.Write("a.png", ""), 1, 1, {128, 128, 255});
  json document = Document();
  document["images"] = {{{"uri", "a.png"}}};
  document["textures"] = {{{"source", 0}}};
  // The existing numbers read as four floats per vertex are (0 0 0 2), (0 0 0 2), (0 0 0 1).
  document["accessors"].push_back(
      {{"bufferView", 4}, {"componentType", 5126}, {"count", 3}, {"type", "VEC4"}});
  document["bufferViews"].push_back(View(0, 48));
  document["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = 4;
  EXPECT_TRUE(Read(document).meshes[0].tangents.empty()) << "nothing to use them";
  document["materials"][0]["normalTexture"] = {{"index", 0}, {"scale", 0.25}};
  const Scene scene = Read(document);
  const Material& paint = scene.materials[0];
  ASSERT_TRUE(paint.normal_texture);
  EXPECT_EQ(scene.textures[*paint.normal_texture].use, TextureUse::kNormals);
  EXPECT_EQ(paint.normal_scale, 0.25f);
  ASSERT_EQ(scene.meshes[0].tangents.size(), 3u);
  EXPECT_EQ(scene.meshes[0].tangents[0].w, 2);
  document["bufferViews"][4]["byteLength"] = 40;
  EXPECT_NE(ErrorOf(document), "");
}

// Colours have three or four channels, as floats or normalized bytes.
TEST_F(Gltf, VertexColoursAreRead) {
  json document = Document();
  document["bufferViews"].push_back(View(0, 48));
  json& primitive = document["meshes"][0]["primitives"][0];
  primitive["attributes"]["COLOR_0"] = 4;
  // The positions serve again as colours: (0 0 0), (2 0 0), (0 2 0), clamped to [0, 1].
  document["accessors"].push_back(
      {{"bufferView", 4}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  const Scene scene = Read(document);
  EXPECT_TRUE(scene.warnings.empty());
  ASSERT_EQ(scene.meshes[0].colors.size(), 3u);
  EXPECT_EQ(scene.meshes[0].colors[0], glm::vec3(0, 0, 0));
  EXPECT_EQ(scene.meshes[0].colors[1], glm::vec3(1, 0, 0));
  EXPECT_EQ(scene.meshes[0].colors[2], glm::vec3(0, 1, 0));
  document["accessors"][4] = {{"bufferView", 4},
                              {"componentType", 5121},
                              {"normalized", true},
                              {"count", 3},
                              {"type", "VEC4"}};
  // The view begins with the last two bytes of a 2.0f: 0, 64, then zeros.
  document["bufferViews"][4] = View(14, 12);
  const Scene four = Read(document);
  ASSERT_EQ(four.meshes[0].colors.size(), 3u);
  EXPECT_EQ(four.meshes[0].colors[0], glm::vec3(0, 64.0f / 255, 0));
  EXPECT_EQ(four.meshes[0].colors[1], glm::vec3(0));
  EXPECT_TRUE(four.warnings.empty());
  document["materials"][0]["alphaMode"] = "BLEND";
  const Scene blended = Read(document);
  EXPECT_TRUE(blended.warnings.empty());
  EXPECT_EQ(blended.meshes[0].alphas, std::vector<float>(3, 0.0f));
  EXPECT_TRUE(four.meshes[0].alphas.empty()) << "the material is opaque";
  EXPECT_TRUE(scene.meshes[0].alphas.empty()) << "there is none";
  document["accessors"][4]["count"] = 2;
  EXPECT_NE(ErrorOf(document), "");
}

TEST_F(Gltf, VolumesAbsorb) {
  json document = Document();
  document["extensionsRequired"] = {"KHR_materials_volume"};
  document["materials"][0]["extensions"] = {
      {"KHR_materials_transmission", {{"transmissionFactor", 1}}},
      {"KHR_materials_volume",
       {{"thicknessFactor", 1},
        {"attenuationDistance", 2.0},
        {"attenuationColor", {0.25, 1.0, 0.5}}}}};
  document["materials"][0]["pbrMetallicRoughness"] = {{"metallicFactor", 0},
                                                      {"roughnessFactor", 0.5}};
  const Scene scene = Read(document);
  EXPECT_TRUE(scene.warnings.empty());
  const glm::vec3 absorption = scene.materials[0].absorption;
  EXPECT_FLOAT_EQ(absorption.x, float(std::log(4.0) / 2));
  EXPECT_EQ(absorption.y, 0);
  EXPECT_FLOAT_EQ(absorption.z, float(std::log(2.0) / 2));
  document["materials"][0]["extensions"]["KHR_materials_volume"].erase("attenuationDistance");
  EXPECT_EQ(Read(document).materials[0].absorption, glm::vec3(0));
}

TEST_F(Gltf, TransmissionAndIndicesMakeGlass) {
  json document = Document();
  document["materials"][0]["extensions"] = {
      {"KHR_materials_transmission", {{"transmissionFactor", 1}}},
      {"KHR_materials_ior", {{"ior", 1.33}}}};
  json& extensions = document["materials"][0]["extensions"];
  EXPECT_EQ(Body(Read(document)).mixture->share, 0.25f) << "the metal";
  document["materials"][0]["pbrMetallicRoughness"] = {{"metallicFactor", 0},
                                                      {"roughnessFactor", 0}};
  EXPECT_EQ(Body(Read(document)).bsdf, BsdfKind::kThinDielectric);
  EXPECT_FLOAT_EQ(Body(Read(document)).ior, 1.33f);
  EXPECT_EQ(Body(Read(document)).reflection, glm::vec3(1));
  document["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 0.5;
  EXPECT_EQ(Body(Read(document)).bsdf, BsdfKind::kRoughThinDielectric);
  EXPECT_FLOAT_EQ(Body(Read(document)).alpha, 0.25f);
  extensions["KHR_materials_volume"] = {{"thicknessFactor", 0.5}};
  document["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 0;
  EXPECT_EQ(Read(document).materials[0].bsdf, BsdfKind::kDielectric);
  document["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 0.5;
  EXPECT_EQ(Read(document).materials[0].bsdf, BsdfKind::kRoughDielectric);
  EXPECT_FLOAT_EQ(Read(document).materials[0].alpha, 0.25f);
  document["materials"][0]["extensions"].erase("KHR_materials_transmission");
  EXPECT_EQ(Read(document).materials[0].bsdf, BsdfKind::kMetallicRoughness);
  EXPECT_FLOAT_EQ(Read(document).materials[0].ior, 1.33f);
}

// KHR_materials_transmission mixes metal and a dielectric by the metal, and the dielectric of glass
// and an opaque body by the transmission.
TEST_F(Gltf, TransmissionIsAShareOfGlass) {
  json document = Document();
  json& material = document["materials"][0];
  json& pbr = material["pbrMetallicRoughness"];
  json& glass = material["extensions"]["KHR_materials_transmission"];
  glass = {{"transmissionFactor", 0.4}};
  const auto read = [&] {
    Scene scene = Read(document);
    EXPECT_EQ(scene.warnings, std::vector<std::string>{});
    return scene;
  };
  const auto part = [](const Scene& scene, std::uint32_t row) { return scene.materials.at(row); };
  pbr = {{"metallicFactor", 1}, {"roughnessFactor", 0}};
  EXPECT_EQ(Body(read()).bsdf, BsdfKind::kMetallicRoughness) << "metal lets nothing through";
  EXPECT_FALSE(Body(read()).mixture);

  pbr = {{"metallicFactor", 0}, {"roughnessFactor", 0}, {"baseColorFactor", {0.2, 0.4, 0.6, 1}}};
  const Scene half = read();
  ASSERT_TRUE(Body(half).mixture);
  EXPECT_FLOAT_EQ(Body(half).mixture->share, 0.4f);
  EXPECT_EQ(Body(half).name, "paint");
  const Material body = part(half, Body(half).mixture->first);
  const Material pane = part(half, Body(half).mixture->second);
  EXPECT_EQ(body.bsdf, BsdfKind::kMetallicRoughness);
  EXPECT_EQ(pane.bsdf, BsdfKind::kThinDielectric);
  ExpectNear(pane.reflectance, {0.2f, 0.4f, 0.6f});
  EXPECT_EQ(pane.reflection, glm::vec3(1));

  // A quarter of metal lies beside the dielectric, three quarters.
  pbr["metallicFactor"] = 0.25;
  const Scene three = read();
  EXPECT_FLOAT_EQ(Body(three).mixture->share, 0.25f);
  EXPECT_EQ(part(three, Body(three).mixture->second).metallic, 1);
  const Material dielectric = part(three, Body(three).mixture->first);
  ASSERT_TRUE(dielectric.mixture);
  EXPECT_FLOAT_EQ(dielectric.mixture->share, 0.4f);
  EXPECT_EQ(part(three, dielectric.mixture->first).metallic, 0);
}

// The red channel of its texture is the transmission, the blue one of that of roughness the metal;
// all glass has the texture of the base colour.
// KHR_materials_diffuse_transmission mixes a sheet into the opaque part of the dielectric, by the
// alpha of its texture; metal has none of it.
TEST_F(Gltf, DiffuseTransmissionIsAShareOfASheet) {
  WritePng(folder_.Write("t.png", ""), 2, 1, {255, 128, 51, 0, 64, 204});
  json document = Document();
  document["images"] = {{{"uri", "t.png"}}};
  document["textures"] = {{{"source", 0}}};
  json& material = document["materials"][0];
  material["pbrMetallicRoughness"] = {{"metallicFactor", 0}, {"roughnessFactor", 0.5}};
  json& extensions = material["extensions"];
  json& sheet = extensions["KHR_materials_diffuse_transmission"];
  sheet = {{"diffuseTransmissionFactor", 0.25},
           {"diffuseTransmissionColorFactor", {0.5, 0.75, 1}},
           {"diffuseTransmissionTexture", {{"index", 0}}},
           {"diffuseTransmissionColorTexture", {{"index", 0}}}};
  const Scene scene = Read(document);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& leaf = Body(scene);
  ASSERT_TRUE(leaf.mixture);
  EXPECT_FALSE(leaf.one_sided);
  EXPECT_EQ(leaf.mixture->share, 0.25f) << "a picture without alpha is opaque";
  EXPECT_EQ(scene.materials[leaf.mixture->first].bsdf, BsdfKind::kMetallicRoughness);
  const Material& passes = scene.materials[leaf.mixture->second];
  EXPECT_EQ(passes.bsdf, BsdfKind::kCoatedDiffuseTransmission);
  EXPECT_EQ(passes.reflectance, glm::vec3(0.5f, 0.75f, 1));
  EXPECT_TRUE(passes.color_texture);
  EXPECT_EQ(passes.alpha, 0.25f);

  sheet["diffuseTransmissionFactor"] = 1;
  EXPECT_EQ(Body(Read(document)).bsdf, BsdfKind::kCoatedDiffuseTransmission);
  // Glass goes before the sheet.
  extensions["KHR_materials_transmission"] = {{"transmissionFactor", 0.4}};
  const Scene both = Read(document);
  ASSERT_TRUE(Body(both).mixture);
  EXPECT_EQ(Body(both).mixture->share, 0.4f);
  EXPECT_EQ(both.materials[Body(both).mixture->first].bsdf, BsdfKind::kCoatedDiffuseTransmission);
  EXPECT_EQ(both.materials[Body(both).mixture->second].bsdf, BsdfKind::kRoughThinDielectric);
  extensions.erase("KHR_materials_transmission");
  extensions["KHR_materials_volume"] = {{"thicknessFactor", 1}};
  extensions["KHR_materials_sheen"] = {{"sheenColorFactor", {1, 1, 1}}};
  const std::vector<std::string> warnings = Read(document).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  const std::string said = warnings[0] + warnings[1];
  EXPECT_NE(said.find("not absorbed"), std::string::npos) << said;
  EXPECT_NE(said.find("without the sheen"), std::string::npos) << said;
  material["pbrMetallicRoughness"]["metallicFactor"] = 1;
  EXPECT_FALSE(Body(Read(document)).mixture) << "metal lets nothing through";
}

TEST_F(Gltf, TransmissionHasTheTexturesOfTheMaterial) {
  WritePng(folder_.Write("a.png", ""), 2, 1, {255, 0, 0, 51, 255, 255});
  WritePng(folder_.Write("m.png", ""), 2, 1, {0, 128, 0, 0, 128, 255});
  WritePng(folder_.Write("w.png", ""), 1, 1, {255, 128, 0});
  json document = Document();
  document["images"] = {{{"uri", "a.png"}}, {{"uri", "m.png"}}, {{"uri", "w.png"}}};
  document["textures"] = {{{"source", 0}}, {{"source", 1}}, {{"source", 2}}};
  json& material = document["materials"][0];
  json& pbr = material["pbrMetallicRoughness"];
  pbr = {{"metallicFactor", 0.5},
         {"baseColorTexture", {{"index", 0}}},
         {"metallicRoughnessTexture", {{"index", 1}}}};
  json& glass = material["extensions"]["KHR_materials_transmission"];
  glass = {{"transmissionFactor", 0.5}, {"transmissionTexture", {{"index", 0}}}};
  const Scene scene = Read(document);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const auto shares = [&](const Material& of) {
    return scene.images[scene.textures.at(of.mixture_texture.value()).image].Floats().rgb;
  };
  const Material whole = Body(scene);
  EXPECT_EQ(shares(whole), (std::vector<float>{0, 0, 0, 0.5f, 0.5f, 0.5f}));
  const Material metal = scene.materials[whole.mixture->second];
  EXPECT_EQ(metal.metallic, 1);
  EXPECT_EQ(scene.images[scene.textures[*metal.roughness_texture].image].Floats().rgb,
            (std::vector<float>{0, 128 / 255.0f, 1, 0, 128 / 255.0f, 1}));
  const Material dielectric = scene.materials[whole.mixture->first];
  EXPECT_EQ(shares(dielectric), (std::vector<float>{0.5f, 0.5f, 0.5f, 0.1f, 0.1f, 0.1f}));
  const Material pane = scene.materials[dielectric.mixture->second];
  EXPECT_EQ(pane.bsdf, BsdfKind::kRoughThinDielectric);
  EXPECT_TRUE(pane.color_texture && pane.roughness_texture);

  // Textures of one value are numbers: no metal, and all glass.
  pbr["metallicRoughnessTexture"]["index"] = 2;
  glass = {{"transmissionFactor", 1}, {"transmissionTexture", {{"index", 2}}}};
  EXPECT_FALSE(Body(Read(document)).mixture);
  EXPECT_EQ(Body(Read(document)).bsdf, BsdfKind::kRoughThinDielectric);
}

// A material that no primitive of the scene uses is not read: its image may be missing.
TEST_F(Gltf, WhatIsUnusedIsNotRead) {
  json document = Document();
  document["images"] = {{{"uri", "missing.png"}}};
  document["textures"] = {{{"source", 0}}};
  document["materials"].push_back({{"name", "unused"}, {"normalTexture", {{"index", 0}}}});
  const Scene scene = Read(document);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  EXPECT_EQ(scene.materials.size(), 1u);
  document["meshes"][0]["primitives"][0]["material"] = 1;
  const Scene used = Read(document);
  ASSERT_EQ(used.warnings.size(), 1u);
  EXPECT_NE(used.warnings[0].find("'unused'"), std::string::npos) << used.warnings[0];
  EXPECT_NE(used.warnings[0].find("missing.png"), std::string::npos) << used.warnings[0];
}

// Specular-glossiness becomes metallic-roughness. Colours without a specular part above 4 % are a
// dielectric's; a black diffuse one leaves a metal of the specular colour.
TEST_F(Gltf, SpecularGlossinessIsConverted) {
  json document = Document();
  json& extension = document["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"];
  extension = {{"diffuseFactor", {0.5, 0.25, 0.125, 1}},
               {"specularFactor", {0.04, 0.04, 0.04}},
               {"glossinessFactor", 0.75}};
  const Material body = Body(Read(document));
  ExpectNear(body.reflectance, {0.5f, 0.25f, 0.125f});
  EXPECT_NEAR(body.metallic, 0, 1e-4);
  EXPECT_FLOAT_EQ(body.alpha, 0.0625f);
  extension["diffuseFactor"] = {0, 0, 0, 1};
  extension["specularFactor"] = {0.9, 0.6, 0.3};
  const Material metal = Body(Read(document));
  ExpectNear(metal.reflectance, {0.9f, 0.6f, 0.3f});
  EXPECT_NEAR(metal.metallic, 1, 1e-5);

  // Texels are converted one by one: a white body, and a metal of half the reflectance. The alpha
  // of the specular texture is the glossiness.
  WritePng(folder_.Write("d.png", ""), 2, 1, {255, 255, 255, 0, 0, 0});
  folder_.Write("s.png", TransparentPng());
  document["images"] = {{{"uri", "d.png"}}, {{"uri", "s.png"}}};
  document["textures"] = {{{"source", 0}}, {{"source", 1}}};
  extension = {{"specularFactor", {0.5, 0.5, 0.5}},
               {"diffuseTexture", {{"index", 0}}},
               {"specularGlossinessTexture", {{"index", 1}}}};
  const Scene scene = Read(document);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const auto texels = [&](std::optional<std::uint32_t> texture) {
    return scene.images[scene.textures.at(texture.value()).image].Floats().rgb;
  };
  const std::vector<float> widths = texels(Body(scene).roughness_texture);
  EXPECT_NEAR(widths[1], 0, 1e-6);
  EXPECT_NEAR(widths[4], 0.8, 1e-6) << "an alpha of a fifth";
  EXPECT_EQ(Body(scene).alpha, 1);
  EXPECT_EQ(Body(scene).reflectance, glm::vec3(1));
}

}  // namespace
}  // namespace skywave
