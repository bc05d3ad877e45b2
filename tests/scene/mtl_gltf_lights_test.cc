// Tests lights of OBJ and glTF files: emission of materials, and punctual lights.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.h"
#include "image/image.h"
#include "scene/geometry.h"
#include "scene/gltf/reader.h"
#include "scene/local_lights.h"
#include "scene/obj/mtl.h"
#include "tests/support/made_image.h"
#include "tests/support/oracle_lights.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

void ExpectNear(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-4f * (1 + glm::length(b)))
      << a.x << " " << a.y << " " << a.z << " against " << b.x << " " << b.y << " " << b.z;
}

Material OnlyMaterial(const std::string& text) {
  Scene scene;
  TextureFiles textures{&scene};
  Warnings warnings;
  return ParseMtl("newmtl a\n" + text, "t.mtl", textures, warnings).at(0);
}

TEST(MtlEmission, IsRadianceOnBothSides) {
  const Material material = OnlyMaterial("Kd .5 .5 .5\nKe 4 2 1\n");
  ExpectNear(material.emission, {4, 2, 1});
  EXPECT_TRUE(material.emits_on_both_sides);
  ExpectNear(OnlyMaterial("Ke 3\n").emission, glm::vec3(3));  // grey
  EXPECT_EQ(OnlyMaterial("Kd 1 1 1\n").emission, glm::vec3(0));
  EXPECT_EQ(OnlyMaterial("illum 7\nKe 1 1 1\n").emission, glm::vec3(1));  // glass can emit too
  try {
    OnlyMaterial("Ke 1 1e20 1\n");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("t.mtl:2: ")) << error.what();
  }
}

TEST(MtlEmission, TakesAMap) {
  TemporaryFolder folder;
  // The picture has one red pixel.
  folder.Write("red.hdr", std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n") +
                              std::string("\x80\0\0\x80", 4));
  Scene scene;
  TextureFiles textures{&scene};
  Warnings warnings;
  const auto materials = ParseMtl("newmtl a\nmap_Ke red.hdr\nnewmtl b\nKe 0 0 0\nmap_Ke red.hdr\n",
                                  folder.Path("t.mtl"), textures, warnings);
  EXPECT_TRUE(warnings.entries.empty());
  EXPECT_EQ(materials[0].emission, glm::vec3(1));
  EXPECT_EQ(materials[0].emission_texture, 0u);
  EXPECT_EQ(materials[1].emission, glm::vec3(0));
  EXPECT_FALSE(materials[1].emission_texture);
}

using nlohmann::json;

class GltfLights : public testing::Test {
 protected:
  // The node with light 0 is rotated and moved by its parent.
  static json Document() {
    return {{"asset", {{"version", "2.0"}}},
            {"extensionsRequired", {"KHR_lights_punctual"}},
            {"extensions",
             {{"KHR_lights_punctual",
               {{"lights", {{{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 8}}}}}}}},
            {"scene", 0},
            {"scenes", {{{"nodes", {0}}}}},
            {"nodes",
             {{{"children", {1}}, {"translation", {1, 2, 3}}, {"scale", {4, 4, 4}}},
              {{"translation", {0, 1, 0}},
               {"rotation", {-0.7071067811865476, 0, 0, 0.7071067811865476}},
               {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}}}};
  }
  // Returns the same with a triangle of each of so many materials.
  static json DocumentOf(const json& materials) {
    json document = Document();
    document["materials"] = materials;
    document["accessors"] = {{{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}};
    for (std::size_t i = 0; i < materials.size(); ++i) {
      document["meshes"][0]["primitives"].push_back(
          {{"attributes", {{"POSITION", 0}}}, {"material", i}});
    }
    document["nodes"][0]["mesh"] = 0;
    return document;
  }
  static json& Light(json& document) {
    return document["extensions"]["KHR_lights_punctual"]["lights"][0];
  }
  Scene Read(const json& document) { return ReadGltf(folder_.Write("a.gltf", document.dump())); }
  TemporaryFolder folder_;
};

TEST_F(GltfLights, PunctualLightsAreRead) {
  json document = Document();
  const PunctualLight point = Read(document).lights.at(0);
  EXPECT_EQ(point.kind, LocalLightKind::kPoint);
  ExpectNear(point.emission, {8, 4, 2});
  ExpectNear(point.position, {1, 6, 3});

  Light(document)["type"] = "directional";
  const PunctualLight sun = Read(document).lights.at(0);
  EXPECT_EQ(sun.kind, LocalLightKind::kDistant);
  ExpectNear(sun.emission, {8, 4, 2});
  // The node looks along -z, rotated by -90 degrees about x, which is down. The light comes from
  // above.
  ExpectNear(sun.direction, {0, 1, 0});

  Light(document)["type"] = "spot";
  Light(document)["spot"] = {{"innerConeAngle", 0.2}, {"outerConeAngle", 0.6}};
  const Scene cone = Read(document);
  EXPECT_TRUE(cone.warnings.empty());
  const PunctualLight spot = cone.lights.at(0);
  EXPECT_EQ(spot.kind, LocalLightKind::kSpot);
  ExpectNear(spot.direction, {0, -1, 0});
  EXPECT_NEAR(spot.cos_full, std::cos(0.2), 1e-6);
  EXPECT_NEAR(spot.cos_dark, std::cos(0.6), 1e-6);
  EXPECT_EQ(spot.curve, SpotCurve::kSquare);
  // All members of a spot have defaults: a cone of a quarter of a turn, dark from its edge on.
  Light(document).erase("spot");
  const PunctualLight plain = Read(document).lights.at(0);
  EXPECT_NEAR(plain.cos_full, 1, 1e-6);
  EXPECT_NEAR(plain.cos_dark, std::sqrt(0.5), 1e-6);
}

TEST_F(GltfLights, EmissionOfMaterialsIsRead) {
  const Scene scene = Read(DocumentOf(
      {{{"name", "dark"}},
       {{"emissiveFactor", {1, 0.5, 0.25}}},
       {{"emissiveFactor", {1, 0.5, 0.25}},
        {"doubleSided", true},
        {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 6}}}}}}}));
  EXPECT_TRUE(scene.warnings.empty());
  ASSERT_EQ(scene.materials.size(), 3u);
  EXPECT_EQ(scene.materials[0].emission, glm::vec3(0));
  ExpectNear(scene.materials[1].emission, {1, 0.5f, 0.25f});
  EXPECT_FALSE(scene.materials[1].emits_on_both_sides);
  ExpectNear(scene.materials[2].emission, {6, 3, 1.5f});
  EXPECT_TRUE(scene.materials[2].emits_on_both_sides);
}

TEST_F(GltfLights, InvalidLightsAreRefused) {
  const auto error_of = [&](const char* pointer, const json& value) -> std::string {
    json document = Document();
    document[json::json_pointer(pointer)] = value;
    try {
      Read(document);
      return "";
    } catch (const InputError& error) {
      EXPECT_EQ(error.exit_code(), kExitBadInput);
      EXPECT_NE(std::string(error.what()).find("a.gltf"), std::string::npos);
      return error.what();
    }
  };
  const std::string light = "/extensions/KHR_lights_punctual/lights/0/";
  ASSERT_EQ(error_of((light + "intensity").c_str(), 3), "");
  EXPECT_NE(error_of((light + "intensity").c_str(), -3), "");
  EXPECT_NE(error_of((light + "intensity").c_str(), 1e30), "");
  EXPECT_NE(error_of("/nodes/1/extensions/KHR_lights_punctual/light", 1), "");
  EXPECT_NE(error_of("/nodes/1/extensions/KHR_lights_punctual/light", -1), "");
  EXPECT_NE(error_of("/nodes/1/extensions/KHR_lights_punctual/light", "x"), "");
  EXPECT_THROW(Read(DocumentOf({{{"emissiveFactor", {-1, 0, 0}}}})), InputError);
  json document = Document();
  Light(document)["type"] = "spot";
  for (const auto& [inner, outer] :
       {std::pair{0.5, 0.4}, std::pair{-0.1, 0.4}, std::pair{0.0, 0.0}, std::pair{0.0, 2.0}}) {
    Light(document)["spot"] = {{"innerConeAngle", inner}, {"outerConeAngle", outer}};
    EXPECT_THROW(Read(document), InputError) << inner << " " << outer;
  }
  Light(document)["type"] = "laser";
  Light(document).erase("spot");
  const Scene scene = Read(document);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_EQ(scene.warnings.size(), 1u);
}

}  // namespace
}  // namespace skywave
