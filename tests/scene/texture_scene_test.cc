// Tests textures of pbrt and OBJ files: their orientation, their factors, and the warnings about
// unsupported ones.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "image/image.h"
#include "scene/reader.h"
#include "tests/support/oracle_texture.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/texture_scene.h"

namespace skywave {
namespace {

TEST_F(PbrtTextureFiles, HaveTheirFirstRowOnTop) {
  const Scene scene = Read(
      "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\" "
      "\"float uscale\" 1 \"float scale\" 0.5\n"
      "Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"rgb scale\" [1 .5 .25]",
      "Material \"diffuse\" \"texture reflectance\" \"s\"");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& material = scene.materials.at(scene.meshes.at(0).material);
  EXPECT_LT(glm::length(material.reflectance - glm::vec3(0.5f, 0.25f, 0.125f)), 1e-6);
  ExpectSeen(scene, material, {0.25, 0.75}, {1, 0, 0});
  ExpectSeen(scene, material, {0.75, 0.75}, {0, 1, 0});
  ExpectSeen(scene, material, {0.25, 0.25}, {0, 0, 1});
}

TEST_F(PbrtTextureFiles, AreReadOnceAndWrappedAsTheySay) {
  const Scene scene = Read(
      "Texture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\"\n"
      "Texture \"b\" \"color\" \"imagemap\" \"string filename\" \"t.png\" \"string wrap\" "
      "\"clamp\" \"float udelta\" 2",
      "Material \"matte\" \"texture Kd\" \"b\"");
  EXPECT_EQ(scene.images.size(), 1u);
  ASSERT_EQ(scene.textures.size(), 2u);
  const Material& material = scene.materials.at(scene.meshes.at(0).material);
  ExpectSeen(scene, material, {0.25, 0.75}, {0, 1, 0});
  ExpectSeen(scene, material, {0.25, 0.25}, {1, 1, 1});
}

TEST_F(PbrtTextureFiles, UnsupportedTexturesAreNamed) {
  const std::string image = "\"imagemap\" \"string filename\" \"t.png\"";
  for (const std::string& texture :
       {image + " \"string mapping\" \"conical\"", image + " \"string wrap\" \"black\"",
        std::string("\"checkerboard\" \"integer dimension\" 4"), std::string("\"ptex\"")}) {
    const Scene scene =
        Read("Texture \"t\" \"spectrum\" " + texture, "Material \"matte\" \"texture Kd\" \"t\"");
    EXPECT_FALSE(scene.warnings.empty()) << texture;
  }
  EXPECT_THROW(Read("Texture \"t\" \"spectrum\" \"imagemap\"", ""), InputError);
}

// The amount, a float, is the share of the second material in version 4, and a colour and that of
// the first one in version 3.
TEST_F(PbrtTextureFiles, AreSharesOfMixtures) {
  const std::string two =
      "MakeNamedMaterial \"a\" \"string type\" \"matte\" MakeNamedMaterial \"b\" \"string "
      "type\" \"mirror\" Material \"mix\" \"texture amount\" \"t\" ";
  const auto map = [](const std::string& type) {
    return "Texture \"t\" \"" + type +
           "\" \"imagemap\" \"string filename\" \"t.png\" \"float scale\" .5";
  };
  const auto shares = [&](const std::string& type, const std::string& names) {
    const Scene scene = Read(map(type), two + names);
    EXPECT_EQ(scene.warnings, std::vector<std::string>{});
    const Material& material = scene.materials.at(scene.meshes.at(0).material);
    return scene.images[scene.textures[material.mixture_texture.value()].image].Floats();
  };
  const std::string named = "\"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\"";
  const Image v4 = shares("float", "\"string materials\" [\"a\" \"b\"]");
  const Image v3 = shares("float", named), of_color = shares("color", named);
  const Image plain = Read(map("color"), "").images.at(0).Floats();
  ASSERT_EQ(v4.rgb.size(), plain.rgb.size());
  for (std::size_t i = 0; i < v4.rgb.size(); i += 3) {
    const float mean = 0.5f * (plain.rgb[i] + plain.rgb[i + 1] + plain.rgb[i + 2]) / 3;
    EXPECT_NEAR(v4.rgb[i], mean, 1e-6);
    EXPECT_NEAR(v3.rgb[i + 1], 1 - mean, 1e-6);
    EXPECT_NEAR(of_color.rgb[i + 1], 1 - mean, 1e-6);
  }
}

TEST_F(PbrtTextureFiles, CoatedMaterialsHaveARoughCoat) {
  const Scene scene = Read("",
                           "Material \"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3] "
                           "\"float roughness\" 0.25 \"float eta\" 1.7");
  const Material& material = scene.materials.at(scene.meshes.at(0).material);
  EXPECT_EQ(material.bsdf, BsdfKind::kCoatedDiffuse);
  EXPECT_FLOAT_EQ(material.alpha, 0.5f);
  EXPECT_FLOAT_EQ(material.ior, 1.7f);
  EXPECT_EQ(material.coat_thickness, 0);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Scene misty =
      Read("", "Material \"coateddiffuse\" \"rgb albedo\" [.1 .2 .3] \"float g\" .4");
  const Material& mist = misty.materials.at(misty.meshes.at(0).material);
  EXPECT_FLOAT_EQ(mist.coat_thickness, 0.01f);  // pbrt's default
  EXPECT_FLOAT_EQ(mist.coat_asymmetry, 0.4f);
  EXPECT_EQ(mist.coat_albedo, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(misty.warnings, std::vector<std::string>{});
  const Scene dark = Read("", "Material \"coateddiffuse\" \"float thickness\" 2");
  EXPECT_EQ(dark.materials.at(dark.meshes.at(0).material).coat_thickness, 2);
  EXPECT_THROW(Read("", "Material \"coateddiffuse\" \"float g\" 1"), InputError);
}

// The image of the metal's width lies in green, that of the coat's in red.
TEST_F(PbrtTextureFiles, RoughnessOfCoats) {
  const std::string image =
      "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"t.png\" \"float scale\" .5\n"
      "Texture \"h\" \"float\" \"scale\" \"texture tex\" \"t\" \"float scale\" .5\n";
  const auto texel = [](const Scene& scene) {
    const Material& coated = scene.materials.at(scene.meshes.at(0).material);
    EXPECT_EQ(scene.warnings, std::vector<std::string>{});
    EXPECT_EQ(coated.alpha, 1);
    const auto rgb =
        scene.images.at(scene.textures.at(coated.roughness_texture.value()).image).Pixel(0, 0);
    return glm::vec3(rgb[0], rgb[1], rgb[2]);
  };
  const glm::vec3 body =
      texel(Read(image,
                 "Material \"coateddiffuse\" \"texture roughness\" \"t\" \"bool remaproughness\" "
                 "false"));
  const float alpha = body.y * body.y;
  EXPECT_GT(alpha, 0.01f);
  const glm::vec3 metal =
      texel(Read(image,
                 "Material \"coatedconductor\" \"texture conductor.roughness\" \"t\" "
                 "\"texture interface.roughness\" \"h\" \"bool remaproughness\" false"));
  EXPECT_NEAR(metal.y * metal.y, alpha, 1e-5f);
  EXPECT_NEAR(metal.x * metal.x, alpha / 2, 1e-5f);
  const Scene two =
      Read(image,
           "Material \"coateddiffuse\" \"texture uroughness\" \"t\" \"texture vroughness\" \"h\" "
           "\"bool remaproughness\" false");
  EXPECT_EQ(two.warnings.size(), 1u);
  const Material& round = two.materials.at(two.meshes.at(0).material);
  const auto rgb =
      two.images.at(two.textures.at(round.roughness_texture.value()).image).Pixel(0, 0);
  EXPECT_NEAR(std::pow(rgb[1], 4.0f), alpha * alpha / 2, 1e-5f);
}

// One name may denote two textures; the parameter that uses it determines which.
TEST_F(PbrtTextureFiles, OfFloatsAndOfColoursHaveNamesOfTheirOwn) {
  const std::string both =
      "Texture \"t\" \"float\" \"constant\" \"float value\" .25\n"
      "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [.9 .5 .1]\n";
  const Scene scene = Read(both,
                           "Material \"coateddiffuse\" \"texture reflectance\" \"t\" "
                           "\"texture roughness\" \"t\" \"bool remaproughness\" false");
  const Material& coated = scene.materials.at(scene.meshes.at(0).material);
  EXPECT_EQ(coated.reflectance, glm::vec3(0.9f, 0.5f, 0.1f));
  EXPECT_EQ(coated.alpha, 0.25f);
  const std::string one = both.substr(0, both.find('\n'));
  for (const Scene& other :
       {Read(one, "Material \"matte\" \"texture Kd\" \"t\""),
        Read(both.substr(one.size()), "Material \"matte\" \"texture sigma\" \"t\"")}) {
    ASSERT_EQ(other.warnings.size(), 1u);
    EXPECT_NE(other.warnings[0].find("names no texture that is there"), std::string::npos);
  }
  EXPECT_THROW(Read("Texture \"t\" \"vector\" \"constant\"", ""), InputError);
}

TEST_F(PbrtTextureFiles, AlphaOfShapesMakesMaterialsOfTheirOwn) {
  const std::string sphere = "Shape \"sphere\" ";
  const Scene scene = ReadScene(folder_.Write(
      "s.pbrt",
      "WorldBegin\nTexture \"t\" \"float\" \"imagemap\" \"string filename\" \"t.png\" "
      "\"float scale\" 0.5\nMaterial \"diffuse\" \"rgb reflectance\" [.1 .2 .3]\n" +
          sphere + "\n" + sphere + "\"float alpha\" 0.25\n" + sphere + "\"texture alpha\" \"t\"\n" +
          sphere + "\"float alpha\" 0.25\n" + sphere + "\"float alpha\" 1\n"));
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  ASSERT_EQ(scene.meshes.size(), 5u);
  const auto material = [&](std::size_t mesh) {
    return scene.materials[scene.meshes[mesh].material];
  };
  EXPECT_TRUE(material(0).opaque() && material(4).opaque());
  EXPECT_EQ(material(1).opacity, 0.25f);
  EXPECT_EQ(material(1).reflectance, material(0).reflectance);
  EXPECT_EQ(scene.meshes[3].material, scene.meshes[1].material);
  EXPECT_EQ(material(2).opacity, 0.5f);
  ASSERT_TRUE(material(2).opacity_texture);
  EXPECT_EQ(scene.textures[*material(2).opacity_texture].use, TextureUse::kOpacity);
}

TEST_F(PbrtTextureFiles, AreNotInterpolatedWithoutAFilter) {
  const auto read = [&](const std::string& file) {
    return Read(
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filter\" \"point\" \"string "
        "filename\" \"" +
            file + "\"",
        "Material \"diffuse\" \"texture reflectance\" \"t\"");
  };
  const Scene scene = read("t.png");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& material = scene.materials.at(scene.meshes.at(0).material);
  for (const double v : {0.52, 0.75, 0.98}) {
    ExpectSeen(scene, material, {0.02, v}, {1, 0, 0});
    ExpectSeen(scene, material, {0.48, v}, {1, 0, 0});
    ExpectSeen(scene, material, {0.52, v}, {0, 1, 0});
  }
  WritePng(folder_.Path("wide.png"), 600, 1, std::vector<std::uint8_t>(1800));
  EXPECT_EQ(read("wide.png").warnings.size(), 1u);
}

// A texture of floats has one value, whatever colours its file has.
TEST_F(PbrtTextureFiles, OfFloatsAreMeansOfColours) {
  const Scene scene = Read(
      "Texture \"f\" \"float\" \"imagemap\" \"string filename\" \"t.png\"\n"
      "Texture \"m\" \"spectrum\" \"mix\" \"rgb tex1\" [0 0 0] \"rgb tex2\" [.9 .6 .3] "
      "\"texture amount\" \"f\"",
      "Material \"diffuse\" \"texture reflectance\" \"m\"");
  const Material& material = scene.materials.at(scene.meshes.at(0).material);
  ExpectSeen(scene, material, {0.25, 0.75}, {0.3, 0.2, 0.1});
  ExpectSeen(scene, material, {0.75, 0.75}, {0.3, 0.2, 0.1});
  ExpectSeen(scene, material, {0.75, 0.25}, {0.9, 0.6, 0.3});
}

// The two pixels have colours (255, 0, 0) and alpha 51, and white and alpha 255. Without an
// encoding, alpha is decoded as colours are.
TEST_F(PbrtTextureFiles, OfFloatsAreAlphaWhereThereIsOne) {
  const unsigned char png[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
      0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x08, 0x06, 0x00, 0x00, 0x00, 0xf4,
      0x22, 0x7f, 0x8a, 0x00, 0x00, 0x00, 0x0f, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8,
      0xcf, 0xc0, 0x60, 0xfc, 0x1f, 0x08, 0x00, 0x12, 0xf6, 0x05, 0x2f, 0x97, 0xc4, 0x2e, 0xcc,
      0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  folder_.Write("a.png", std::string(reinterpret_cast<const char*>(png), sizeof png));
  const auto shares = [&](const std::string& encoding) {
    const Scene scene =
        Read("Texture \"f\" \"float\" \"imagemap\" \"string filename\" \"a.png\"" + encoding,
             "MakeNamedMaterial \"a\" \"string type\" \"matte\" MakeNamedMaterial \"b\" \"string "
             "type\" \"mirror\" Material \"mix\" \"texture amount\" \"f\" \"string materials\" "
             "[\"a\" \"b\"]");
    const Material& material = scene.materials.at(scene.meshes.at(0).material);
    return scene.images[scene.textures[material.mixture_texture.value()].image].Floats().rgb;
  };
  const std::vector<float> linear = shares(" \"string encoding\" \"linear\""), srgb = shares("");
  ASSERT_EQ(linear.size(), 6u);
  EXPECT_NEAR(linear[0], 0.2f, 1e-6f);
  EXPECT_NEAR(srgb[1], std::pow((0.2 + 0.055) / 1.055, 2.4), 1e-6);
  EXPECT_EQ(srgb[5], 1.0f);
}

// Grey of 51 and 128 with alpha 255 and 51, and a palette of green with alpha 51 and white: pbrt
// drops the alpha of both. It keeps that of OpenEXR files, as it is.
TEST_F(PbrtTextureFiles, OfFloatsAreAlphaBesideThreeColoursOnly) {
  const unsigned char grey[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
      0x44, 0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x08, 0x04, 0x00, 0x00,
      0x00, 0x5e, 0x2b, 0xb7, 0x01, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x44, 0x41, 0x54, 0x78,
      0xda, 0x63, 0x30, 0xfe, 0xdf, 0x60, 0x0c, 0x00, 0x05, 0x01, 0x01, 0xe6, 0xae, 0x5d,
      0x52, 0xb0, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  const unsigned char palette[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
      0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x08, 0x03, 0x00, 0x00, 0x00, 0xc3,
      0xfc, 0x8f, 0xb8, 0x00, 0x00, 0x00, 0x06, 0x50, 0x4c, 0x54, 0x45, 0x00, 0xff, 0x00, 0xff,
      0xff, 0xff, 0x6f, 0xbd, 0x58, 0x51, 0x00, 0x00, 0x00, 0x01, 0x74, 0x52, 0x4e, 0x53, 0x33,
      0xff, 0x36, 0xb9, 0x70, 0x00, 0x00, 0x00, 0x0b, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63,
      0x60, 0x60, 0x04, 0x00, 0x00, 0x04, 0x00, 0x02, 0x2c, 0xde, 0x48, 0xad, 0x00, 0x00, 0x00,
      0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  folder_.Write("g.png", std::string(reinterpret_cast<const char*>(grey), sizeof grey));
  folder_.Write("p.png", std::string(reinterpret_cast<const char*>(palette), sizeof palette));
  Image colors(2, 1);
  colors.rgb = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};
  WriteExr(folder_.Path("a.exr"), colors, {}, {{"A", {0.25f, 1}}});
  const auto values = [&](const std::string& file) {
    const Scene scene =
        Read("Texture \"f\" \"float\" \"imagemap\" \"string filename\" \"" + file + "\"",
             "Shape \"sphere\" \"texture alpha\" \"f\"");
    const std::vector<float> rgb = scene.images.at(scene.textures.at(0).image).Floats().rgb;
    return std::pair(rgb.at(0), rgb.at(3));
  };
  const std::string linear = "\" \"string encoding\" \"linear",
                    point = "\" \"string filter\" \"point";
  const std::pair<float, float> of_grey = values("g.png" + linear);
  EXPECT_NEAR(of_grey.first, 51 / 255.0, 1e-6);
  EXPECT_NEAR(of_grey.second, 128 / 255.0, 1e-6);
  const std::pair<float, float> of_palette = values("p.png" + linear);
  EXPECT_NEAR(of_palette.first, 1 / 3.0, 1e-6);
  EXPECT_EQ(of_palette.second, 1);
  EXPECT_EQ(values("a.exr"), std::pair(0.25f, 1.0f));
  // Without a filter it takes the first channel.
  EXPECT_EQ(values("a.exr" + point).first, 0.1f);
}

// Pixels of a TGA of 32 bits, rows from the top: blue, green, red, alpha.
std::string TgaFile(int width, const std::string& pixels) {
  const std::string header("\0\0\2\0\0\0\0\0\0\0\0\0", 12);
  return header + char(width) + std::string("\0\1\0\x20\x20", 5) + pixels;
}

// pbrt drops the alpha channel of a TGA. Exponents are for all files of 8 bits.
TEST_F(PbrtTextureFiles, OfTgaHaveColorsAlone) {
  folder_.Write("a.tga", TgaFile(1, "\x33\x66\x99\x80"));
  const auto map = [](const std::string& type, const std::string& encoding) {
    return "Texture \"t\" \"" + type + "\" \"imagemap\" \"string filename\" \"a.tga\"" + encoding;
  };
  const auto texels = [](const Scene& scene, std::optional<std::uint32_t> Material::*use) {
    EXPECT_EQ(scene.warnings, std::vector<std::string>{});
    const Material& material = scene.materials.at(scene.meshes.at(0).material);
    return scene.images[scene.textures[(material.*use).value()].image].Floats().rgb;
  };
  const auto color = [&](const std::string& encoding) {
    return texels(Read(map("spectrum", encoding), "Material \"matte\" \"texture Kd\" \"t\""),
                  &Material::color_texture);
  };
  EXPECT_NEAR(color("")[0], 0.318547, 1e-5);  // IEC 61966-2-1
  EXPECT_NEAR(color(" \"string encoding\" \"linear\"")[0], 0.6, 1e-6);
  EXPECT_NEAR(color(" \"string encoding\" \"gamma 2\"")[2], 0.04, 1e-6);
  const Scene mix =
      Read(map("float", " \"string encoding\" \"linear\""),
           "MakeNamedMaterial \"a\" \"string type\" \"matte\" MakeNamedMaterial \"b\" \"string "
           "type\" \"mirror\" Material \"mix\" \"texture amount\" \"t\" \"string materials\" "
           "[\"a\" \"b\"]");
  EXPECT_NEAR(texels(mix, &Material::mixture_texture)[1], 0.4, 1e-6);
}

TEST_F(PbrtTextureFiles, AreHeightsAndNormalsOfMaterials) {
  const std::string heights =
      "Texture \"h\" \"float\" \"imagemap\" \"string filename\" \"t.png\" \"float scale\" 0.1\n";
  for (const char* const name : {"displacement", "bumpmap"}) {
    const Scene scene =
        Read(heights, "Material \"matte\" \"texture " + std::string(name) + "\" \"h\"");
    EXPECT_EQ(scene.warnings, std::vector<std::string>{});
    const Material& material = scene.materials.at(scene.meshes.at(0).material);
    ASSERT_TRUE(material.normal_texture) << name;
    EXPECT_EQ(material.normal_scale, 0.1f);
    EXPECT_EQ(scene.textures[*material.normal_texture].use, TextureUse::kHeights);
  }
  const Scene scene = Read("", "Material \"diffuse\" \"string normalmap\" \"t.png\"");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& material = scene.materials.at(scene.meshes.at(0).material);
  ASSERT_TRUE(material.normal_texture);
  EXPECT_EQ(scene.textures[*material.normal_texture].use, TextureUse::kPbrtNormals);
}

TEST(MtlTextures, AlphaAndReliefAreOfEveryMaterialButGlass) {
  const TemporaryFolder folder;
  WriteFourColors(folder, "colors.png");
  WritePng(folder.Path("grey.png"), 2, 1, {51, 51, 51, 255, 255, 255});
  const auto read = [&](const std::string& statements) {
    folder.Write("a.mtl", "newmtl m\n" + statements + "\n");
    return ReadScene(
        folder.Write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"));
  };
  const auto material = [](const Scene& scene) {
    return scene.materials.at(scene.meshes.at(0).material);
  };
  const Scene holes = read("Kd 1 1 1\nd 0.75\nmap_d grey.png");
  EXPECT_EQ(holes.warnings, std::vector<std::string>{});
  EXPECT_EQ(material(holes).opacity, 0.75f);
  ASSERT_TRUE(material(holes).opacity_texture);
  const Texture& texture = holes.textures[*material(holes).opacity_texture];
  EXPECT_FLOAT_EQ(holes.images[texture.image].Floats().rgb[0], 0.2f) << "numbers, no sRGB";
  EXPECT_TRUE(material(read("Kd 1 1 1\nd 1")).opaque());
  folder.Write("leaf.tga", TgaFile(2, std::string("abc\x33gh\xff\xff", 8)));
  const Scene leaf = read("Kd 1 1 1\nmap_Kd leaf.tga\nmap_d leaf.tga");
  ASSERT_TRUE(material(leaf).opacity_texture);
  const Texture& alpha = leaf.textures[*material(leaf).opacity_texture];
  EXPECT_FLOAT_EQ(leaf.images[alpha.image].Floats().rgb[0], 0.2f);

  const Scene bumps = read("Kd 1 1 1\nbump -bm 3 grey.png");
  ASSERT_TRUE(material(bumps).normal_texture);
  EXPECT_EQ(bumps.textures[*material(bumps).normal_texture].use, TextureUse::kHeights);
  EXPECT_TRUE(material(bumps).height_in_texels);
  EXPECT_FLOAT_EQ(material(bumps).normal_scale, 0.06f);
  for (const char* const words : {"map_Bump colors.png", "bump colors.png", "norm grey.png"}) {
    const Scene scene = read(std::string("Kd 1 1 1\n") + words);
    ASSERT_TRUE(material(scene).normal_texture) << words;
    EXPECT_EQ(scene.textures[*material(scene).normal_texture].use, TextureUse::kNormals) << words;
    EXPECT_EQ(material(scene).normal_scale, 1) << words;
  }
  EXPECT_TRUE(material(read("illum 7\nmap_d grey.png")).opaque());
}

// Without coordinates every triangle has the lower right half of the unit square.
TEST_F(PbrtTextureFiles, LieOnTrianglesWithoutCoordinates) {
  const std::string textures =
      "Texture \"c\" \"color\" \"imagemap\" \"string filename\" \"t.png\"\n"
      "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"t.png\"\n";
  const std::string square =
      "\"point P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [0 1 2 0 2 3] ";
  folder_.Write("m.ply",
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Scene scene = ReadScene(folder_.Write(
      "s.pbrt", "WorldBegin\n" + textures + "Shape \"trianglemesh\" " + square +
                    "Shape \"trianglemesh\" \"texture alpha\" \"a\" " + square +
                    "Material \"diffuse\" \"texture reflectance\" \"c\"\n"
                    "Shape \"trianglemesh\" \"normal N\" [0 0 -1 0 0 -1 0 0 -1 0 0 -1] " +
                    square +
                    "Shape \"plymesh\" \"string filename\" \"m.ply\"\n"
                    "Shape \"loopsubdiv\" \"integer levels\" 1 " +
                    square));
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  ASSERT_EQ(scene.meshes.size(), 5u);
  EXPECT_TRUE(scene.meshes[0].uvs.empty());
  EXPECT_EQ(scene.meshes[0].positions.size(), 4u);
  for (std::size_t i = 1; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    SCOPED_TRACE(mesh.name);
    ASSERT_EQ(mesh.uvs.size(), 3 * mesh.triangles.size());
    ASSERT_EQ(mesh.positions.size(), mesh.uvs.size());
    for (const glm::uvec3& t : mesh.triangles) {
      // A mesh is turned to the side of its normals, which those of loopsubdiv lie against, and
      // the coordinates stay with their corners.
      const bool turned = i == 2 || mesh.name.starts_with("loopsubdiv");
      EXPECT_EQ(mesh.uvs[t.x], glm::vec2(0, 0));
      EXPECT_EQ(mesh.uvs[turned ? t.z : t.y], glm::vec2(1, 0));
      EXPECT_EQ(mesh.uvs[turned ? t.y : t.z], glm::vec2(1, 1));
    }
  }
}

TEST(MtlTextures, HaveTheirFirstRowOnTopAndTheirOptions) {
  const TemporaryFolder folder;
  WriteFourColors(folder, "t.png");
  const auto read = [&](const std::string& statements) {
    folder.Write("a.mtl", "newmtl m\n" + statements + "\n");
    return ReadScene(folder.Write("a.obj",
                                  "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\n"
                                  "vt 0 1\nusemtl m\nf 1/1 2/2 3/3\n"));
  };
  const auto material = [](const Scene& scene) {
    return scene.materials.at(scene.meshes.at(0).material);
  };
  const Scene plain = read("Kd .5 .5 .5\nmap_Kd t.png");
  EXPECT_EQ(plain.warnings, std::vector<std::string>{});
  EXPECT_EQ(material(plain).reflectance, glm::vec3(0.5f));
  ExpectSeen(plain, material(plain), {0.25, 0.75}, {1, 0, 0});
  ExpectSeen(plain, material(plain), {1.75, 0.25}, {1, 1, 1});
  const Scene moved = read("Kd 0 0 0\nmap_Kd -clamp on -o 0.5 0 0 -s 1 1 1 t.png");
  EXPECT_EQ(material(moved).reflectance, glm::vec3(1));
  ExpectSeen(moved, material(moved), {0.25, 0.75}, {0, 1, 0});
  ExpectSeen(moved, material(moved), {9, 0.75}, {0, 1, 0});
  ExpectSeen(moved, material(moved), {0.25, 0.25}, {1, 1, 1});
  const Scene coated = read("Kd 1 1 1\nKs .5 .5 .5\nNs 98\nmap_Kd t.png");
  EXPECT_EQ(material(coated).bsdf, BsdfKind::kMetallicRoughness);
  EXPECT_NEAR(material(coated).alpha, std::sqrt(0.02), 1e-6);
  EXPECT_TRUE(material(coated).color_texture);
  folder.Write("t.png", "no picture");
  const Scene broken = read("map_Kd t.png");
  EXPECT_FALSE(material(broken).color_texture);
  EXPECT_EQ(broken.warnings.size(), 1u);
}

// Each statement has options of its own, with a number for each axis; v points up.
TEST(MtlTextures, LieAsTheirOwnStatementsSay) {
  const TemporaryFolder folder;
  WriteFourColors(folder, "t.png");
  WritePng(folder.Path("grey.png"), 2, 1, {51, 51, 51, 255, 255, 255});
  folder.Write("a.mtl",
               "newmtl m\nKd 1 1 1\nKe 1 1 1\nmap_Kd -s 2 3 1 -o .125 .25 0 t.png\n"
               "map_Ke -s 5 7 1 -o .5 .75 0 t.png\nmap_d -s 11 13 1 -o 2 3 0 grey.png\n"
               "bump -s 17 19 1 -o 4 5 0 grey.png\n");
  const Scene scene = ReadScene(
      folder.Write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"));
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& material = scene.materials.at(scene.meshes.at(0).material);
  const auto expect = [&](const std::optional<std::uint32_t>& texture, const glm::vec2& scale,
                          const glm::vec2& offset) {
    ASSERT_TRUE(texture);
    const glm::vec2 uv(0.25f, 0.5f), up = scale * uv + offset;
    const glm::vec2 at = scene.textures.at(*texture).transform * glm::vec3(uv, 1);
    EXPECT_LT(glm::length(at - glm::vec2(up.x, 1 - up.y)), 1e-6f) << at.x << " " << at.y;
  };
  expect(material.color_texture, {2, 3}, {0.125f, 0.25f});
  expect(material.emission_texture, {5, 7}, {0.5f, 0.75f});
  expect(material.opacity_texture, {11, 13}, {2, 3});
  expect(material.normal_texture, {17, 19}, {4, 5});
}

}  // namespace
}  // namespace skywave
