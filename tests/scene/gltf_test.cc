// Tests glTF files: the scenes they become, and everything that is refused.
#include "scene/gltf/reader.h"

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

// Triangle i of a strip is (i, i + 1 + i % 2, i + 2 - i % 2), that of a fan (i + 1, i + 2, 0)
// (glTF 2.0, 3.7.2.1).
TEST(GltfMeshes, StripsAndFansAreWoundAsTheSpecificationSays) {
  using Triangles = std::vector<glm::uvec3>;
  const auto triangles = [](int mode) {
    GltfDocument document;
    const int positions =
        document.Add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, "VEC3");
    document.json["meshes"] = {
        {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"mode", mode}}}}}};
    document.json["nodes"] = {{{"mesh", 0}}};
    document.json["scenes"] = {{{"nodes", {0}}}};
    Triangles found = ParseGltf(document.text(), "a.gltf").meshes.at(0).triangles;
    for (glm::uvec3& t : found) {  // begin with the least number
      while (t.x > t.y || t.x > t.z) t = {t.y, t.z, t.x};
    }
    return found;
  };
  EXPECT_EQ(triangles(5), (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
  EXPECT_EQ(triangles(6), (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

// Positions, coordinates of two sets and a number that is not read, vertex by vertex in one view.
TEST(GltfMeshes, AttributesMayBeInterleavedAndMaterialsChooseTheirCoordinates) {
  GltfDocument document;
  std::vector<float> vertices;
  for (int i = 0; i < 3; ++i) {
    const float n = float(i);
    for (const float number : {n, 10 + n * n, -n, 77.f, 0.1f * n, 0.2f, 0.3f, 0.4f + n}) {
      vertices.push_back(number);
    }
  }
  const int view = document.AddView(vertices);
  document.json["bufferViews"][0]["byteStride"] = 32;
  const auto accessor = [&](int offset, const char* type) {
    document.json["accessors"].push_back({{"bufferView", view},
                                          {"byteOffset", offset},
                                          {"componentType", 5126},
                                          {"count", 3},
                                          {"type", type}});
    return document.json["accessors"].size() - 1;
  };
  const auto positions = accessor(0, "VEC3"), first = accessor(16, "VEC2"),
             second = accessor(24, "VEC2");
  document.json["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", first}, {"TEXCOORD_1", second}}},
          {"material", 0}}}}}};
  document.json["nodes"] = {{{"mesh", 0}}};
  document.json["scenes"] = {{{"nodes", {0}}}};
  const TemporaryFolder folder;
  WritePng(folder.Path("a.png"), 1, 1, {255, 0, 0});
  document.json["images"] = {{{"uri", "a.png"}}};
  document.json["textures"] = {{{"source", 0}}};
  json color = {{"index", 0}};
  const auto mesh = [&] {
    document.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", color}}}}};
    return ParseGltf(document.text(), folder.Path("a.gltf")).meshes.at(0);
  };
  const Mesh plain = mesh();
  ASSERT_EQ(plain.positions.size(), 3u);
  ASSERT_EQ(plain.uvs.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const float n = float(i);
    EXPECT_EQ(plain.positions[i], glm::vec3(n, 10 + n * n, -n));
    EXPECT_EQ(plain.uvs[i], glm::vec2(0.1f * n, 0.2f));
  }
  color["texCoord"] = 1;
  EXPECT_EQ(mesh().uvs.at(2), glm::vec2(0.3f, 2.4f));
  // The extension has the last word.
  color["extensions"]["KHR_texture_transform"] = {{"texCoord", 0}};
  EXPECT_EQ(mesh().uvs.at(2), glm::vec2(0.2f, 0.2f));
  color["extensions"]["KHR_texture_transform"] = {{"scale", {2, 2}}};
  EXPECT_EQ(mesh().uvs.at(2), glm::vec2(0.3f, 2.4f));
}

// The textures of a material have the coordinates of two sets, in the order in which its textures
// name them; a third set, and a mesh that lacks what its textures use, are named.
TEST_F(Gltf, TexturesHaveTwoSetsOfCoordinates) {
  WritePng(folder_.Write("a.png", ""), 1, 1, {255, 0, 0});
  json document = Document();
  document["images"] = {{{"uri", "a.png"}}};
  document["textures"] = {{{"source", 0}}};
  json& material = document["materials"][0];
  material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}, {"texCoord", 1}};
  material["normalTexture"] = {{"index", 0}};
  // The positions' first numbers, (0, 0), (0, 2) and (0, 0), are the second set.
  document["bufferViews"].push_back(View(0, 24));
  document["accessors"].push_back(
      {{"bufferView", 4}, {"componentType", 5126}, {"count", 3}, {"type", "VEC2"}});
  json& attributes = document["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_1"] = 4;
  const Scene scene = Read(document);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const Material& paint = scene.materials[scene.meshes[0].material];
  EXPECT_EQ(scene.textures[paint.color_texture.value()].uv_set, UvSet::kFirst);
  EXPECT_EQ(scene.textures[paint.normal_texture.value()].uv_set, UvSet::kSecond);
  EXPECT_EQ(scene.meshes[0].uvs.at(1), glm::vec2(0, 2));
  EXPECT_EQ(scene.meshes[0].second_uvs.at(1), glm::vec2(1, 0));

  attributes.erase("TEXCOORD_1");
  material["emissiveFactor"] = {1, 1, 1};
  material["emissiveTexture"] = {{"index", 0}, {"texCoord", 2}};
  const std::vector<std::string> warnings = Read(document).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  const std::string said = warnings[0] + warnings[1];
  EXPECT_NE(said.find("more than two sets of texture coordinates"), std::string::npos) << said;
  EXPECT_NE(said.find("textures use TEXCOORD_1, which it lacks"), std::string::npos) << said;
}

TEST_F(Gltf, UnsupportedFeaturesAreNamed) {
  json document = Document();
  document["materials"][0]["extensions"] = {{"KHR_materials_dispersion", json::object()},
                                            {"KHR_materials_variants", json::object()}};
  const std::vector<std::string> warnings = Read(document).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  for (const char* const word : {"KHR_materials_variants", "KHR_materials_dispersion"}) {
    EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [&](const std::string& text) {
      return text.find(word) != std::string::npos;
    })) << word;
  }
}

// What is said of many materials is one line, with the first names and the number of the others.
TEST_F(Gltf, WarningsOfManyMaterialsAreOneLine) {
  json document = Document();
  json& primitives = document["meshes"][0]["primitives"];
  document["extensionsRequired"] = {"KHR_materials_dispersion"};
  for (int i = 0; i < 5; ++i) {
    document["materials"].push_back(
        {{"name", std::string("m") + char('0' + i)},
         {"extensions", {{"KHR_materials_dispersion", json::object()}}}});
    primitives.push_back(primitives[0]);
    primitives.back()["material"] = i + 1;
  }
  const std::vector<std::string> warnings = Read(document).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("materials 'm0', 'm1', 'm2' and 2 more: the extension KHR_materials_"),
            std::string::npos)
      << warnings[0];
  try {
    ParseGltf(document.dump(), folder_.Path("a.gltf"), {.strict = true});
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("material 'm0': "), std::string::npos);
  }
}

// Names of the reader's own are no files, and names of files are not the reader's.
TEST_F(Gltf, ImagesMayHaveAnyName) {
  json document = Document();
  document["textures"] = {{{"source", 0}}};
  document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  for (const char* const name : {"skywave-buffer-", "skywave-buffer-x", "skywave-buffer-99",
                                 "skywave-buffer-99999999999999999999999"}) {
    document["images"] = {{{"uri", name}}};
    EXPECT_EQ(Read(document).warnings.size(), 1u) << name;
  }
}

TEST_F(Gltf, InconsistentFilesAreRefused) {
  ASSERT_EQ(ErrorOf(Document()), "");
  const auto refused = [&](const char* pointer, const json& value) {
    json document = Document();
    document[json::json_pointer(pointer)] = value;
    EXPECT_NE(ErrorOf(document), "") << pointer << " = " << value;
  };
  refused("/nodes/1/children", {0});
  refused("/nodes/1/children", {1});
  refused("/nodes/1/children", {2});
  refused("/nodes/0/children", {1, 7});
  refused("/nodes/1/mesh", 5);
  refused("/scene", 3);
  refused("/scenes/0/nodes", {9});
  refused("/meshes/0/primitives/0/material", 4);
  refused("/meshes/0/primitives/0/indices", 9);
  refused("/meshes/0/primitives/0/indices", 0);
  refused("/meshes/0/primitives/0/attributes/POSITION", 9);
  refused("/meshes/0/primitives/0/attributes/POSITION", 2);
  refused("/accessors/0/count", 4);
  refused("/accessors/0/count", 1000000000);
  refused("/accessors/0/byteOffset", 4);
  refused("/accessors/0/byteOffset", 4000000000u);
  refused("/accessors/0/bufferView", 17);
  refused("/accessors/0/componentType", 5130);
  refused("/accessors/1/count", 2);
  refused("/accessors/3/componentType", 5126);
  refused("/bufferViews/0/byteLength", 500);
  refused("/bufferViews/0/byteOffset", 1000);
  refused("/bufferViews/0/buffer", 3);
  refused("/bufferViews/0/byteStride", 4);
  refused("/buffers/0/byteLength", 1000);
  refused("/buffers/0/uri", "missing.bin");
  refused("/buffers/0/uri", "../a.bin");
  refused("/buffers/0/uri", "/etc/hostname");
  refused("/buffers/0/uri", "x/../../a.bin");
  refused("/buffers/0/uri", "data:application/octet-stream;base64,AAAA");
  refused("/extensionsRequired", {"EXT_geometry_of_tomorrow"});
  refused("/asset/version", "1.0");
  refused("/asset/minVersion", "2.1");
  refused("/nodes/1/scale", {std::numeric_limits<double>::max(), 1, 1});
  for (const char* const uri : {"../a.png", "/a.png"}) {
    json document = Document();
    document["images"] = {{{"uri", uri}}};
    document["textures"] = {{{"source", 0}}};
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    EXPECT_NE(ErrorOf(document), "") << uri;
  }
  {  // The specification and its extensions have these alone.
    WritePfm(folder_.Path("a.pfm"), Image(1, 1));
    json document = Document();
    document["images"] = {{{"uri", "a.pfm"}}};
    document["textures"] = {{{"source", 0}}};
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    EXPECT_NE(Read(document).warnings.at(0).find("neither PNG, JPEG nor WebP"), std::string::npos);
  }
  for (const char* const pointer : {"/bufferView", "/mimeType"}) {
    json document = Document();
    document["images"] = {{{"bufferView", 0}, {"mimeType", "image/png"}}};
    document["images"][0][pointer + 1] = pointer[1] == 'b' ? json(44) : json("image/png");
    document["bufferViews"][0]["byteOffset"] = 90;
    document["textures"] = {{{"source", 0}}};
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    EXPECT_NE(ErrorOf(document), "") << pointer;
  }
  EXPECT_NE(ErrorOfFile(folder_.Write("e.gltf", "")), "");
  EXPECT_NE(ErrorOfFile(folder_.Write("e.gltf", "{}")), "");
  EXPECT_NE(ErrorOfFile(folder_.Write("e.gltf", "[1, 2]")), "");
}

// Broken and missing textures are left out; the warning names texture, reason and material.
TEST_F(Gltf, TexturesThatCannotBeReadAreLeftOut) {
  for (const char* const uri :
       {"missing.png", "a.bin", "data:image/png;base64,AAAA", "data:image/webp;base64,AAAA"}) {
    json document = Document();
    document["images"] = {{{"uri", uri}}};
    document["textures"] = {{{"source", 0}}};
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    const Scene scene = Read(document);
    ASSERT_EQ(scene.warnings.size(), 1u) << uri;
    EXPECT_NE(scene.warnings[0].find("material 'paint'"), std::string::npos) << scene.warnings[0];
    EXPECT_FALSE(scene.materials[0].color_texture) << uri;
    EXPECT_THROW(ReadGltf(folder_.Path("a.gltf"), {.strict = true}), InputError);
  }
}

// Each texel is a square of texels, so that interpolation changes its rim alone.
TEST_F(Gltf, NearestSamplersShowSquares) {
  WritePng(folder_.Write("n.png", ""), 2, 1, {255, 0, 0, 0, 0, 255});
  json document = Document();
  document["images"] = {{{"uri", "n.png"}}};
  document["samplers"] = {{{"magFilter", 9728}}};
  document["textures"] = {{{"source", 0}, {"sampler", 0}}};
  document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  const Scene scene = Read(document);
  EXPECT_TRUE(scene.warnings.empty());
  const Image& image = scene.images[scene.textures.at(0).image];
  ASSERT_GE(image.width, 32);
  ASSERT_EQ(image.width, 2 * image.height);
  for (int x = 0; x < image.width; ++x) {
    EXPECT_EQ(image.Pixel(x, 0)[0], x < image.height ? 1 : 0) << x;
    EXPECT_EQ(image.Pixel(x, 0)[2], x < image.height ? 0 : 1) << x;
  }
  WritePng(folder_.Write("n.png", ""), 513, 1, std::vector<unsigned char>(513 * 3, 7));
  const Scene large = Read(document);
  ASSERT_EQ(large.warnings.size(), 1u);
  EXPECT_NE(large.warnings[0].find("NEAREST"), std::string::npos) << large.warnings[0];
}

// Weights of a node are taken before those of its mesh; such nodes share no triangles.
TEST_F(Gltf, MorphTargetsMoveByTheirWeights) {
  json document = Document();
  // The positions serve again as displacements.
  document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}};
  document["meshes"][0]["weights"] = {0.5};
  document["nodes"][2]["weights"] = {2.0};
  const Scene scene = Read(document);
  ASSERT_EQ(scene.meshes.size(), 2u);
  ExpectNear(scene.meshes[0].positions[1], {7, 0, 0});  // 1 + 2 * (2 + 0.5 * 2)
  ExpectNear(scene.meshes[1].positions[1], {1, 6, 0});  // turned: 2 + 2 * 2
  document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 9}}};
  EXPECT_NE(ErrorOf(document), "");
}

TEST_F(Gltf, AccessorsWithoutViewsAreZero) {
  json document = Document();
  document["accessors"][2].erase("bufferView");
  const Scene scene = Read(document);
  EXPECT_EQ(scene.meshes.at(0).uvs.at(1), glm::vec2(0));
  // Corners 0, 1, 2, of which the last two are replaced by 0 and 1.
  document["accessors"][3]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", 3}, {"byteOffset", 2}, {"componentType", 5123}}},
      {"values", {{"bufferView", 3}}}};
  EXPECT_EQ(Read(document).meshes.at(0).triangles, std::vector<glm::uvec3>{glm::uvec3(0, 0, 1)});
}

// All corners of a triangle without a view are vertex 0.
TEST_F(Gltf, IndicesWithoutViewsAreZero) {
  json document = Document();
  document["accessors"][3].erase("bufferView");
  EXPECT_EQ(Read(document).meshes.at(0).triangles, std::vector<glm::uvec3>{glm::uvec3(0)});
}

// A buffer has at least as many bytes as the file says (3.6.1).
TEST_F(Gltf, BuffersMayBeLongerThanTheFileSays) {
  folder_.Write("a.bin", Buffer() + "more");
  EXPECT_EQ(ReadGltf(folder_.Write("b.gltf", Document().dump())).meshes.size(), 2u);
}

// Files of version 1 name their things by words.
TEST_F(Gltf, OtherVersionsAreNamed) {
  json document = Document();
  document["asset"]["version"] = "1.0";
  EXPECT_NE(ErrorOf(document).find("glTF 1.0"), std::string::npos);
  document["asset"] = json::object();
  document["meshes"] = {{"triangle", json::object()}};
  EXPECT_NE(ErrorOf(document).find("glTF 1.0"), std::string::npos);
  document = Document();
  document["asset"]["minVersion"] = "2.1";
  EXPECT_NE(ErrorOf(document).find("2.1"), std::string::npos);
  std::string glb = Glb(Document(), Buffer());
  glb[4] = 3;
  EXPECT_THROW(ParseGltf(glb, "a.glb"), InputError);
}

TEST_F(Gltf, PrimitivesWithoutPositionsAreLeftOut) {
  json document = Document();
  json second = document["meshes"][0]["primitives"][0];
  second["attributes"].erase("POSITION");
  document["meshes"][0]["primitives"].push_back(second);
  const Scene scene = Read(document);
  EXPECT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("'triangle'"), std::string::npos) << scene.warnings[0];
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

TEST_F(Gltf, NamesInWarningsHoldNoControlCodes) {
  json document = Document();
  document["meshes"][0]["name"] =
      "\x1b[31m\xc2\x9b"
      "red";
  document["meshes"][0]["primitives"][0]["attributes"].erase("POSITION");
  const Scene scene = Read(document);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("'?[31m??red'"), std::string::npos) << scene.warnings[0];
}

TEST_F(Gltf, EveryPrefixIsRefusedAndEveryFlippedBitSurvived) {
  const std::string file = Glb(Document(), Buffer());
  ASSERT_EQ(ErrorOfFile(folder_.Write("a.glb", file)), "");
  for (std::size_t length = 0; length < file.size(); ++length) {
    ASSERT_NE(ErrorOfFile(folder_.Write("a.glb", file.substr(0, length))), "") << length;
  }
  for (std::size_t bit = 0; bit < file.size() * 8; bit += 3) {
    std::string damaged = file;
    damaged[bit / 8] = char(damaged[bit / 8] ^ (1 << bit % 8));
    ErrorOfFile(folder_.Write("a.glb", damaged));
  }
}

}  // namespace
}  // namespace skywave
