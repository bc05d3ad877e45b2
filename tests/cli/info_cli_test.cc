// Tests skywave info: its counts in the table and in the JSON, and its error messages.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "base/error.h"
#include "kernels/bsdf/bsdf.h"
#include "tests/support/gltf_document.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class Info : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    Put("a.mtl",
        "newmtl red\nKd 1 0 0\nmap_Kd a.png\nnewmtl glass\nillum 7\nNi 1.3\nnewmtl gold\n"
        "Kd 0 0 0\nKs 1 .8 .3\nNs 98\n");
    Put("a.obj",
        "mtllib a.mtl\nv 0 0 -1\nv 2 0 0\nv 0 3 0\nv 0 0 0\ns off\nusemtl red\nf 1 2 3\nf 1 2 4\n"
        "s 1\nusemtl glass\nf 1 3 4\n");
    Put("light.pbrt",
        "Camera \"orthographic\"\nWorldBegin\nLightSource \"infinite\" \"rgb L\" [1 2 3]\n"
        "LightSource \"laser\"\nLightSource \"point\" \"rgb I\" [2 2 2]\n"
        "Shape \"sphere\"\nAreaLightSource \"diffuse\"\nShape \"trianglemesh\" \"point P\" [0 0 0 "
        "1 0 0 0 1 0]\n");
    Put("empty.obj", "v 0 0 0\n");
    Put("bad.obj", "v 0 0 0\nf 1 2 x\n");
  }
};

TEST_F(Info, CountsAnObjFile) {
  const Result result = Run("info a.obj --json i.json");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* const part :
       {"triangles   3\n", "0 0 -1 to 2 3 0", "right-handed, y up", "4 materials", "red", "glass",
        "ior 1.3", "a.mtl:3: map_Kd", "--env MAP"}) {
    EXPECT_TRUE(Contains(result.out, part)) << part << " in\n" << result.out;
  }
  const auto json = nlohmann::json::parse(Bytes("i.json"));
  EXPECT_EQ(json.at("schema"), "skywave-scene-info-1");
  EXPECT_EQ(json.at("meshes"), 2);
  EXPECT_EQ(json.at("meshes_with_normals"), 1);
  EXPECT_EQ(json.at("meshes_with_uvs"), 0);
  EXPECT_EQ(json.at("triangles"), 3);
  EXPECT_EQ(json.at("vertices"), 7);
  EXPECT_EQ(json.at("bounds").at("low"), nlohmann::json({0, 0, -1}));
  EXPECT_EQ(json.at("bounds").at("high"), nlohmann::json({2, 3, 0}));
  EXPECT_EQ(json.at("has_camera"), false);
  const auto& materials = json.at("materials");
  ASSERT_EQ(materials.size(), 4u);
  EXPECT_EQ(materials[0].at("name"), "default");
  EXPECT_EQ(materials[0].at("triangles"), 0);
  EXPECT_EQ(materials[1].at("triangles"), 2);
  EXPECT_EQ(materials[1].at("bsdf"), "lambert");
  EXPECT_EQ(materials[1].at("reflectance"), nlohmann::json({1, 0, 0}));
  EXPECT_EQ(materials[2].at("bsdf"), "dielectric");
  EXPECT_EQ(materials[3].at("bsdf"), "conductor");
  EXPECT_EQ(json.at("lights"), nlohmann::json::array());
  EXPECT_EQ(json.at("not_supported").size(), 1u);
  // There are 7 positions, 3 normals and 3 triangles of three words each.
  EXPECT_EQ(json.at("bytes").at("meshes"), (7 + 3 + 3) * 12);
  EXPECT_GT(json.at("bytes").at("geometry").get<int>(), 0);
  EXPECT_GE(json.at("seconds").at("load").get<double>(), 0);
}

TEST_F(Info, ListsCamerasAndAnimations) {
  Put("moving.gltf", MovingTriangle().text());
  const Result result = Run("info moving.gltf --frame 24 --animation slide --json i.json");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* const part : {"2 cameras", "side", "2 animations", "turn", "2 s, 1 channels"}) {
    EXPECT_TRUE(Contains(result.out, part)) << part << " in\n" << result.out;
  }
  const auto json = nlohmann::json::parse(Bytes("i.json"));
  ASSERT_EQ(json.at("cameras").size(), 2u);
  EXPECT_EQ(json.at("cameras")[1].at("name"), "side");
  EXPECT_EQ(json.at("cameras")[1].at("eye"), nlohmann::json({4, 1, 3}));
  ASSERT_EQ(json.at("animations").size(), 2u);
  EXPECT_EQ(json.at("animations")[0],
            nlohmann::json({{"name", "slide"}, {"seconds", 1}, {"channels", 1}}));
  // Frame 24 is the end of the slide, which moves the triangle to the origin.
  EXPECT_NEAR(json.at("bounds").at("low")[0].get<double>(), 0, 1e-6);
}

// Three nodes show the triangle of one mesh, which is there once where it is shared.
TEST_F(Info, CountsTheTrianglesOfEveryInstance) {
  GltfDocument document = TriangleDocument();
  document.json["scenes"][0]["nodes"] = {0, 2, 3};
  for (const int x : {1, 2}) {
    document.json["scenes"][0]["nodes"].push_back(document.json["nodes"].size());
    document.json["nodes"].push_back({{"mesh", 0}, {"translation", {x, 0, 0}}});
  }
  Put("three.gltf", document.text());
  const Result result = Run("info three.gltf --instances share --json i.json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(Bytes("i.json"));
  EXPECT_EQ(json.at("triangles"), 1);
  EXPECT_EQ(json.at("objects"), 1);
  EXPECT_EQ(json.at("instances"), 3);
  EXPECT_EQ(json.at("triangles_with_instances"), 3);
  EXPECT_TRUE(Contains(result.out, "3 of 1 objects: 3 triangles are seen")) << result.out;
}

TEST_F(Info, KnowsLightsCamerasAndBuiltinScenes) {
  const Result pbrt = Run("info light.pbrt --json i.json");
  EXPECT_EQ(pbrt.exit_code, 0) << pbrt.err;
  for (const char* const part : {"left-handed", "orthographic", "3 lights", "1 2 3", "triangle",
                                 "shines with 1 1 1", "light.pbrt:4: LightSource \"laser\""}) {
    EXPECT_TRUE(Contains(pbrt.out, part)) << part << " in\n" << pbrt.out;
  }
  const auto json = nlohmann::json::parse(Bytes("i.json"));
  EXPECT_EQ(json.at("lights").at(0).at("scale"), nlohmann::json({1, 2, 3}));
  EXPECT_EQ(json.at("lights").at(1).at("kind"), "triangle");
  EXPECT_EQ(json.at("lights").at(1).at("count"), 1);
  EXPECT_NEAR(json.at("lights").at(1).at("power").get<double>(), 0.5 * M_PI, 1e-5);
  EXPECT_EQ(json.at("lights").at(2).at("kind"), "point");
  EXPECT_NEAR(json.at("lights").at(2).at("power").get<double>(), 8 * M_PI, 1e-4);
  EXPECT_EQ(json.at("camera").at("kind"), "orthographic");
  const Result gallery = Run("info gallery");
  EXPECT_EQ(gallery.exit_code, 0) << gallery.err;
  EXPECT_TRUE(Contains(gallery.out, "map of 1024 x 512")) << gallery.out;
}

const std::set<std::string_view> kReflectionLayers = {"specular", "specular_color", "film",
                                                      "film_ior", "film_thin",      "film_thick"};

// The scene has a material of each BSDF but eight, which BeyondTheBuiltinOnes and measured ones
// are.
TEST_F(Info, ListsTheParametersOfEveryBsdf) {
  const Result result = Run("info materials --json i.json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(Bytes("i.json"));
  std::set<std::string> seen;
  for (const auto& material : json.at("materials")) {
    for (const BsdfKernels& bsdf : Bsdfs()) {
      if (material.at("bsdf") != bsdf.name) continue;
      seen.insert(std::string(bsdf.name));
      for (const MaterialParameter& parameter : ParametersOf(bsdf)) {
        // This glass has no layers.
        const bool there = !bsdf.glass_layers || !kReflectionLayers.contains(parameter.name);
        EXPECT_EQ(material.contains(parameter.name), there) << parameter.name << " in " << material;
      }
    }
  }
  EXPECT_EQ(seen.size(), kBsdfKinds - 8);
  const auto& phong = json.at("materials").at(4);
  EXPECT_EQ(phong.at("gloss"), nlohmann::json({0.4f, 0.4f, 0.4f})) << phong;
  EXPECT_EQ(phong.at("alpha"), 0.15f) << phong;
}

TEST_F(Info, ListsThePartsThatAMaterialHas) {
  Put("leaf.gltf",
      R"({"asset": {"version": "2.0"}, "materials": [{"name": "leaf", "emissiveFactor": [1, 2, 3],
      "doubleSided": true, "alphaMode": "BLEND",
      "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}},
      {"name": "ruby", "pbrMetallicRoughness": {"metallicFactor": 0},
      "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
      "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 1,
      "attenuationColor": [1, 0.5, 0.5]}}}],
      "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [
      {"material": 0, "attributes": {"POSITION": 0}},
      {"material": 1, "attributes": {"POSITION": 0}}]}],
      "accessors": [{"componentType": 5126, "count": 3, "type": "VEC3"}]})");
  const Result result = Run("info leaf.gltf --json i.json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto materials = nlohmann::json::parse(Bytes("i.json")).at("materials");
  EXPECT_EQ(materials.at(0).at("opacity"), 0.5f);
  EXPECT_EQ(materials.at(0).at("emission"), nlohmann::json({1, 2, 3}));
  EXPECT_EQ(materials.at(0).at("emits_on_both_sides"), true);
  EXPECT_FALSE(materials.at(0).contains("absorption")) << materials;
  EXPECT_FALSE(materials.at(1).contains("emission")) << materials;
  EXPECT_NEAR(materials.at(1).at("absorption").at(1).get<double>(), std::log(2), 1e-5);
  EXPECT_TRUE(Contains(result.out, "absorption 0 0.693147 0.693147")) << result.out;
}

TEST_F(Info, AnEmptySceneHasNoBounds) {
  const Result result = Run("info empty.obj --json i.json");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(Bytes("i.json"));
  EXPECT_EQ(json.at("triangles"), 0);
  EXPECT_FALSE(json.contains("bounds"));
}

TEST_F(Info, ASceneIsNeverOverwritten) {
  const std::string before = Bytes("a.obj");
  EXPECT_EQ(Run("info a.obj --json ./a.obj").exit_code, kExitUsage);
  EXPECT_EQ(Bytes("a.obj"), before);
}

TEST_F(Info, BadInputIsReportedAndLeavesNoFile) {
  const std::set<std::string> before = Files();
  const Result bad = Run("info bad.obj --json i.json");
  EXPECT_EQ(bad.exit_code, kExitBadInput);
  EXPECT_TRUE(Contains(bad.err, "bad.obj:2: ")) << bad.err;
  EXPECT_EQ(bad.out, "");
  EXPECT_EQ(Run("info a.obj --json missing/i.json").exit_code, kExitIo);
  EXPECT_EQ(Run("info nosuch.obj").exit_code, kExitBadInput);
  EXPECT_EQ(Run("info").exit_code, kExitUsage);
  EXPECT_EQ(Files(), before);
}

}  // namespace
}  // namespace skywave
