// Tests the skins of glTF files: vertices, normals and tangents against values worked out by hand.
#include <gtest/gtest.h>

#include "base/error.h"
#include "scene/gltf/reader.h"
#include "tests/support/gltf_document.h"

namespace skywave {
namespace {

void ExpectNear(const glm::vec3& a, const glm::dvec3& b) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(double(a[i]), b[i], 2e-6) << a.x << " " << a.y << " " << a.z;
  }
}

// Returns a triangle with two joints: node 1, which moves by (10, 0, 0), and its child, node 2,
// which turns x to y. The node of the mesh is elsewhere. The first vertex follows the first joint,
// the second one the second joint, and the third one both alike.
GltfDocument SkinnedTriangle() {
  GltfDocument document;
  const int positions = document.Add<float>({1, 0, 0, 2, 0, 0, 0, 4, 0}, "VEC3");
  const int normals = document.Add<float>({1, 0, 0, 1, 0, 0, 0, 0, 1}, "VEC3");
  const int joints = document.Add<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4");
  const int weights = document.Add<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4");
  document.json["scenes"] = {{{"nodes", {0, 1}}}};
  document.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {100, 100, 100}}},
                            {{"translation", {10, 0, 0}}, {"children", {2}}},
                            {{"rotation", {0, 0, 0.7071067811865476, 0.7071067811865476}}}};
  document.json["meshes"] = {{{"name", "worm"},
                              {"primitives",
                               {{{"attributes",
                                  {{"POSITION", positions},
                                   {"NORMAL", normals},
                                   {"JOINTS_0", joints},
                                   {"WEIGHTS_0", weights}}}}}}}};
  document.json["skins"] = {{{"joints", {1, 2}}}};
  return document;
}
Scene Read(const GltfDocument& document) { return ParseGltf(document.text(), "a.gltf"); }

// Joints put vertices in the world; the node of the mesh does not count (3.7.3.3).
TEST(GltfSkins, VerticesFollowTheirJoints) {
  const Scene scene = Read(SkinnedTriangle());
  EXPECT_TRUE(scene.warnings.empty());
  const Mesh& mesh = scene.meshes.at(0);
  ExpectNear(mesh.positions[0], {11, 0, 0});
  ExpectNear(mesh.positions[1], {10, 2, 0});
  ExpectNear(mesh.positions[2], {10 - 2, 2, 0});  // halfway between (10, 4) and (6, 0)
  ExpectNear(mesh.normals[0], {1, 0, 0});
  ExpectNear(mesh.normals[1], {0, 1, 0});
  ExpectNear(mesh.normals[2], {0, 0, 1});
}

TEST(GltfSkins, InverseBindMatricesComeFirst) {
  GltfDocument document = SkinnedTriangle();
  std::vector<float> matrices(32);
  for (int i = 0; i < 4; ++i) matrices[5 * std::size_t(i)] = matrices[16 + 5 * std::size_t(i)] = 1;
  matrices[16 + 12] = -2;  // the second joint was bound at (2, 0, 0)
  document.json["skins"][0]["inverseBindMatrices"] = document.Add<float>(matrices, "MAT4");
  ExpectNear(Read(document).meshes[0].positions[1], {10, 0, 0});
  matrices.resize(16);
  document.json["skins"][0]["inverseBindMatrices"] = document.Add<float>(matrices, "MAT4");
  EXPECT_THROW(Read(document), InputError) << "one matrix for two joints";
}

// Normals turn with the cofactors of the blended matrix, also where it mirrors; then the triangle
// turns round as well.
TEST(GltfSkins, ScalesBendNormals) {
  GltfDocument document = SkinnedTriangle();
  document.json["nodes"][1]["scale"] = {1, 2, 1};
  document.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      document.Add<float>({0.6f, 0.8f, 0, 1, 0, 0, 0, 0, 1}, "VEC3");
  const glm::dvec3 bent = glm::normalize(glm::dvec3(0.6, 0.4, 0));
  ExpectNear(Read(document).meshes[0].normals[0], bent);
  EXPECT_EQ(Read(document).meshes[0].triangles[0], glm::uvec3(0, 1, 2));
  document.json["nodes"][1]["scale"] = {-1, 2, 1};
  ExpectNear(Read(document).meshes[0].normals[0], {-bent.x, bent.y, 0});
  EXPECT_EQ(Read(document).meshes[0].triangles[0], glm::uvec3(0, 2, 1));
}

TEST(GltfSkins, WeightsAreNormalisedWithAWarning) {
  GltfDocument document = SkinnedTriangle();
  nlohmann::json& attributes = document.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["WEIGHTS_0"] = document.Add<float>({1, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  const Scene scene = Read(document);
  ExpectNear(scene.meshes[0].positions[1], {10, 2, 0});
  ExpectNear(scene.meshes[0].positions[2], {10, 4, 0});  // without weights: the first joint
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("'worm'"), std::string::npos) << scene.warnings[0];
}

// A second set of joints adds to the first one.
TEST(GltfSkins, EightJointsMoveAVertex) {
  GltfDocument document = SkinnedTriangle();
  nlohmann::json& attributes = document.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_1"] =
      document.Add<std::uint16_t>({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  attributes["WEIGHTS_0"] =
      document.Add<float>({0.25f, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4");
  attributes["WEIGHTS_1"] = document.Add<float>({0.75f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  ExpectNear(Read(document).meshes[0].positions[0], {10.25, 0.75, 0});
}

TEST(GltfSkins, WhatDoesNotExistIsRefused) {
  const auto refused = [](const char* pointer, const nlohmann::json& value) {
    GltfDocument document = SkinnedTriangle();
    document.json[nlohmann::json::json_pointer(pointer)] = value;
    EXPECT_THROW(Read(document), InputError) << pointer << " = " << value;
  };
  refused("/nodes/0/skin", 1);
  refused("/skins/0/joints", nlohmann::json::array());
  refused("/skins/0/joints", {1, 7});
  refused("/skins/0/joints", {1});
  refused("/meshes/0/primitives/0/attributes/WEIGHTS_0", 0);
}

}  // namespace
}  // namespace skywave
