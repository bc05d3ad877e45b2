// Tests the nodes of glTF files: instances, cameras, transforms, names, visibility.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "scene/gltf/reader.h"
#include "tests/support/gltf_document.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

// Three nodes of a mesh, and two instances each in the last one.
json DocumentOfInstances() {
  GltfDocument document = TriangleDocument();
  const int moves = document.Add<float>({0, 1, 0, 0, 2, 0}, "VEC3");
  const int turns =
      document.Add<float>({0, 0, 0, 1, 0, std::sqrt(0.5f), 0, std::sqrt(0.5f)}, "VEC4");
  const int scales = document.Add<float>({1, 1, 1, 3, 1, 1}, "VEC3");
  json whole = json::parse(document.text());
  const int mesh = 0;
  whole["nodes"] = {
      {{"mesh", mesh}},
      {{"mesh", mesh}, {"translation", {10, 0, 0}}},
      {{"mesh", mesh},
       {"translation", {0, 0, 7}},
       {"extensions",
        {{"EXT_mesh_gpu_instancing",
          {{"attributes", {{"TRANSLATION", moves}, {"ROTATION", turns}, {"SCALE", scales}}}}}}}}};
  whole["scenes"] = {{{"nodes", {0, 1, 2}}}};
  whole["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  whole["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  return whole;
}

TEST_F(Gltf, NodesThatShareAMeshAreInstances) {
  const std::string path = folder_.Write("a.gltf", DocumentOfInstances().dump());
  ReadOptions options;
  options.instances = InstanceUse::kShare;
  const Scene shared = ReadGltf(path, options);
  EXPECT_EQ(shared.objects.size(), 1u);
  ASSERT_EQ(shared.instances.size(), 4u);
  // (1, 0, 0) of the mesh, by scale, turn and move of the instance and the move of the node.
  const glm::dvec4 corner(1, 0, 0, 1);
  ExpectNear(shared.instances[1].world_from_object * corner, {11, 0, 0});
  ExpectNear(shared.instances[2].world_from_object * corner, {1, 1, 7});
  ExpectNear(shared.instances[3].world_from_object * corner, {0, 2, 4});
  const Scene copied = ReadGltf(path);
  ASSERT_EQ(copied.meshes.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    ExpectNear(copied.meshes[i].positions[1], shared.instances[i].world_from_object * corner);
  }
}

// Shared or copied, a mesh goes by the name of the node that stands it there, too.
TEST_F(Gltf, MeshesAndInstancesHaveTheNamesOfTheirNodes) {
  json document = DocumentOfInstances();
  document["nodes"][0]["name"] = "left";
  document["nodes"][2]["name"] = "crowd";
  const std::string path = folder_.Write("a.gltf", document.dump());
  ReadOptions options;
  options.instances = InstanceUse::kShare;
  const Scene shared = ReadGltf(path, options);
  std::vector<std::string> names;
  for (const Instance& instance : shared.instances) {
    names.push_back(instance.node == kNoNode ? "" : shared.nodes[instance.node]);
  }
  const std::vector<std::string> expected = {"left", "", "crowd", "crowd"};
  EXPECT_EQ(names, expected);
  names.clear();
  for (const Mesh& mesh : ReadGltf(path).meshes) names.push_back(mesh.node);
  EXPECT_EQ(names, expected);
  document["scenes"] = {{{"nodes", {0}}}};
  document["nodes"] = {{{"mesh", 0}, {"name", "alone"}}};
  const Scene alone = ReadGltf(folder_.Write("b.gltf", document.dump()));
  EXPECT_EQ(alone.meshes[0].node, "alone");
}

TEST_F(Gltf, InstancesOfAnExtensionAreChecked) {
  const auto change = [&](const char* attribute, const json& value) {
    json document = DocumentOfInstances();
    document["nodes"][2]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"][attribute] = value;
    return ErrorOf(document);
  };
  EXPECT_EQ(ErrorOf(DocumentOfInstances()), "");
  EXPECT_NE(change("SCALE", 0).find("of 2 and of 3"), std::string::npos);
  EXPECT_NE(change("ROTATION", 1).find("has not 4 components"), std::string::npos);
  EXPECT_NE(change("ROTATION", 99).find("99"), std::string::npos);
  EXPECT_NE(change("TRANSLATION", "no").find("TRANSLATION is not an accessor"), std::string::npos);
  json document = DocumentOfInstances();
  document["nodes"][2]["extensions"]["EXT_mesh_gpu_instancing"] = {{"attributes", 3}};
  EXPECT_NE(ErrorOf(document).find("no attributes"), std::string::npos);
  // A sparse accessor without a buffer view has as many zeros as it says.
  document = DocumentOfInstances();
  json& scales = document["accessors"].back();
  scales["sparse"] = {{"count", 1},
                      {"indices", {{"bufferView", 0}, {"componentType", 5125}}},
                      {"values", {{"bufferView", 0}}}};
  scales.erase("bufferView");
  scales["count"] = 1'000'000'000;
  EXPECT_NE(ErrorOf(document).find("1000000000 elements"), std::string::npos) << ErrorOf(document);
}

TEST_F(Gltf, InstancesAreMovedByTheirNodes) {
  for (const bool binary : {false, true}) {
    const Scene scene =
        binary ? ReadGltf(folder_.Write("a.glb", Glb(Document(), Buffer()))) : Read(Document());
    ASSERT_EQ(scene.meshes.size(), 2u);
    ExpectNear(scene.meshes[0].positions[1], {5, 0, 0});
    ExpectNear(scene.meshes[1].positions[1], {1, 2, 0});
    ExpectNear(scene.meshes[1].normals[1], {0, 0, 1});
    EXPECT_EQ(scene.meshes[0].triangles, std::vector<glm::uvec3>{glm::uvec3(0, 1, 2)});
    EXPECT_EQ(scene.meshes[0].uvs[1], glm::vec2(1, 0));
    const Material& paint = scene.materials[scene.meshes[0].material];
    EXPECT_EQ(paint.bsdf, BsdfKind::kMetallicRoughness);
    EXPECT_EQ(paint.name, "paint");
    ExpectNear(paint.reflectance, {0.5f, 0.25f, 1});
    EXPECT_FLOAT_EQ(paint.alpha, 0.25f);
    EXPECT_FLOAT_EQ(paint.metallic, 0.25f);
    EXPECT_FALSE(scene.left_handed);
    EXPECT_TRUE(scene.warnings.empty());
  }
}

TEST_F(Gltf, CamerasLookAlongMinusZ) {
  json document = Document();
  document["cameras"] = {{{"type", "perspective"},
                          {"perspective", {{"yfov", 1.0}, {"znear", 0.1}, {"aspectRatio", 1.5}}}}};
  document["nodes"].push_back({{"camera", 0}, {"translation", {0, 3, 0}}});
  document["scenes"][0]["nodes"].push_back(3);
  const Scene scene = Read(document);
  ASSERT_TRUE(scene.camera);
  const glm::mat4& world = scene.camera->world_from_camera;
  ExpectNear(glm::vec3(world * glm::vec4(0, 0, 1, 1)), {0, 3, -1});
  ExpectNear(glm::vec3(world * glm::vec4(1, 0, 0, 0)), {1, 0, 0});
  EXPECT_NEAR(scene.camera->fov_degrees, glm::degrees(1.0), 1e-4);
}

// yfov is the vertical angle of a view that has the aspect of the camera, or none.
TEST_F(Gltf, CamerasShowTheirWholeViewOnAnyFilm) {
  const auto camera = [&](const json& from) {
    json document = Document();
    document["cameras"] = {from};
    document["nodes"].push_back({{"camera", 0}});
    document["scenes"][0]["nodes"].push_back(3);
    return Read(document).camera.value();
  };
  const auto perspective = [&](double aspect) {
    return camera({{"type", "perspective"},
                   {"perspective", {{"yfov", 1.0}, {"znear", 0.1}, {"aspectRatio", aspect}}}});
  };
  // Returns the tangents of half the angles that the film sees, from left to right and from below.
  const auto seen = [](const Camera& from, int width, int height) {
    const CameraView view = MakeCameraView(from, width, height, nullptr, std::nullopt);
    const float pixel = view.right[0];
    EXPECT_NEAR(pixel, -view.down[1], 1e-6) << "pixels are square";
    EXPECT_NEAR(view.corner[0], -pixel * float(width) / 2, 1e-6) << "the view is in the middle";
    EXPECT_NEAR(view.corner[1], pixel * float(height) / 2, 1e-6);
    return glm::vec2(pixel * float(width) / 2, pixel * float(height) / 2);
  };
  const auto expect = [&](const Camera& from, int width, int height, double x, double y) {
    const glm::vec2 half = seen(from, width, height);
    EXPECT_NEAR(half.x, x, 1e-5) << width << " x " << height;
    EXPECT_NEAR(half.y, y, 1e-5) << width << " x " << height;
  };
  const double up = std::tan(0.5);
  expect(perspective(2), 200, 100, 2 * up, up);
  expect(perspective(2), 300, 100, 3 * up, up);
  expect(perspective(2), 100, 100, 2 * up, 2 * up);
  expect(perspective(0.25), 100, 100, up, up);
  expect(perspective(0.25), 10, 100, 0.25 * up, 2.5 * up);
  const Camera open =
      camera({{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
  expect(open, 300, 100, 3 * up, up), expect(open, 100, 300, up / 3, up);
  const Camera parallel =
      camera({{"type", "orthographic"},
              {"orthographic", {{"xmag", 3.0}, {"ymag", 2.0}, {"znear", 0}, {"zfar", 9}}}});
  EXPECT_EQ(parallel.kind, CameraKind::kOrthographic);
  ASSERT_TRUE(parallel.window);
  EXPECT_EQ(parallel.window->left, -3);
  EXPECT_EQ(parallel.window->right, 3);
  EXPECT_EQ(parallel.window->bottom, -2);
  EXPECT_EQ(parallel.window->top, 2);
  expect(parallel, 300, 100, 6, 2), expect(parallel, 100, 100, 3, 3);
}

// The film has the aspect of the camera, and the scale of the camera's nodes does not count.
TEST_F(Gltf, CamerasGiveTheFilmTheirAspect) {
  json document = Document();
  document["cameras"] = {{{"type", "perspective"},
                          {"perspective", {{"yfov", 1.0}, {"znear", 0.1}, {"aspectRatio", 1.6}}}}};
  document["nodes"].push_back({{"camera", 0}, {"scale", {2, 5, -3}}});
  document["scenes"][0]["nodes"].push_back(3);
  const Scene scene = Read(document);
  EXPECT_EQ(scene.settings.width, 640);
  EXPECT_EQ(scene.settings.height, 400);
  const glm::mat4& world = scene.camera.value().world_from_camera;
  ExpectNear(glm::vec3(world[0]), {1, 0, 0}), ExpectNear(glm::vec3(world[1]), {0, 1, 0});
  ExpectNear(glm::vec3(world[2]), {0, 0, 1});
  document["cameras"][0]["perspective"]["aspectRatio"] = 0.5;
  EXPECT_EQ(Read(document).settings.width, 320);
  EXPECT_EQ(Read(document).settings.height, 640);
  document["cameras"][0]["perspective"].erase("aspectRatio");
  EXPECT_FALSE(Read(document).settings.width);
}

// A matrix is listed by columns (glTF 2.0, 3.5.3); a scale comes before the rotation.
TEST_F(Gltf, NodesHaveAMatrixOrAScaleForEachAxis) {
  json document = Document();
  document["nodes"][1] = {{"mesh", 0},
                          {"matrix", {0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 7, 8, 9, 1}}};
  document["nodes"][2]["scale"] = {3, 5, 7};
  document["nodes"][2]["translation"] = {0, 0, 4};
  const Scene scene = Read(document);
  // The parent moves by (1, 0, 0). The first columns take x to y and y to z.
  ExpectNear(scene.meshes.at(0).positions[1], {8, 10, 9});
  ExpectNear(scene.meshes.at(0).positions[2], {8, 8, 11});
  ExpectNear(scene.meshes.at(1).positions[1], {1, 6, 4});
  ExpectNear(scene.meshes.at(1).positions[2], {-9, 0, 4});
}

TEST_F(Gltf, TheDefaultSceneIsRead) {
  json document = Document();
  document["nodes"][0].erase("children");
  document["scenes"] = {{{"nodes", {1}}}, {{"nodes", {0, 2}}}};
  document["scene"] = 1;
  const Scene second = Read(document);
  ASSERT_EQ(second.meshes.size(), 1u);
  ExpectNear(second.meshes[0].positions[1], {0, 2, 0});
  document.erase("scene");
  const Scene first = Read(document);
  ASSERT_EQ(first.meshes.size(), 1u);
  ExpectNear(first.meshes[0].positions[1], {4, 0, 0});
  // Without any scene, nodes without a parent are shown.
  document = Document();
  document.erase("scene"), document.erase("scenes");
  EXPECT_EQ(Read(document).meshes.size(), 2u);
}

TEST_F(Gltf, HiddenNodesHideAllBelowThem) {
  json document = Document();
  document["nodes"][1]["extensions"] = {{"KHR_node_visibility", {{"visible", false}}}};
  EXPECT_EQ(Read(document).meshes.size(), 1u);
  document["nodes"][0]["extensions"] = {{"KHR_node_visibility", {{"visible", true}}}};
  EXPECT_EQ(Read(document).meshes.size(), 1u);
  document["nodes"][0]["extensions"] = {{"KHR_node_visibility", {{"visible", false}}}};
  EXPECT_EQ(Read(document).meshes.size(), 0u);
}

}  // namespace
}  // namespace skywave
