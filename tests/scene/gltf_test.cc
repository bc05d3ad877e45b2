// Tests glTF files: the scenes they become, and everything that is refused.
#include "scene/gltf/reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/files.h"
#include "image/image.h"
#include "scene/geometry.h"
#include "tests/support/gltf_document.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

using nlohmann::json;

// The buffer of a triangle with normals and coordinates: positions, normals, uvs, indices.
std::string Buffer() {
  const float numbers[] = {0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  const std::uint16_t indices[] = {0, 1, 2, 0};
  std::string bytes(sizeof numbers + sizeof indices, '\0');
  std::memcpy(bytes.data(), numbers, sizeof numbers);
  std::memcpy(bytes.data() + sizeof numbers, indices, sizeof indices);
  return bytes;
}

json View(int offset, int length) {
  return {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}};
}

json Document() {
  return {{"asset", {{"version", "2.0"}}},
          {"scene", 0},
          {"scenes", {{{"nodes", {0}}}}},
          {"nodes",
           {{{"children", {1, 2}}, {"translation", {1, 0, 0}}},
            {{"mesh", 0}, {"scale", {2, 2, 2}}},
            {{"mesh", 0}, {"rotation", {0, 0, 0.7071067811865476, 0.7071067811865476}}}}},
          {"meshes",
           {{{"name", "triangle"},
             {"primitives",
              {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}},
                {"indices", 3},
                {"material", 0}}}}}}},
          {"materials",
           {{{"name", "paint"},
             {"pbrMetallicRoughness",
              {{"baseColorFactor", {0.5, 0.25, 1, 1}},
               {"metallicFactor", 0.25},
               {"roughnessFactor", 0.5}}}}}},
          {"accessors",
           {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
            {{"bufferView", 1}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
            {{"bufferView", 2}, {"componentType", 5126}, {"count", 3}, {"type", "VEC2"}},
            {{"bufferView", 3}, {"componentType", 5123}, {"count", 3}, {"type", "SCALAR"}}}},
          {"bufferViews", {View(0, 36), View(36, 36), View(72, 24), View(96, 6)}},
          {"buffers", {{{"uri", "a.bin"}, {"byteLength", 104}}}}};
}

// Returns the same as one binary file.
std::string Glb(json document, std::string bytes) {
  document["buffers"][0].erase("uri");
  document["buffers"][0]["byteLength"] = bytes.size();
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
  std::string file = "glTF";
  const auto add = [&](std::size_t number) {
    for (int i = 0; i < 4; ++i) file.push_back(char(number >> 8 * i));
  };
  add(2), add(12 + 8 + text.size() + 8 + bytes.size());
  add(text.size()), file += "JSON" + text;
  add(bytes.size()), file += std::string("BIN\0", 4) + bytes;
  return file;
}

class Gltf : public testing::Test {
 protected:
  Gltf() { folder_.Write("a.bin", Buffer()); }
  Scene Read(const json& document) { return ReadGltf(folder_.Write("a.gltf", document.dump())); }
  // Returns the reader's message, or "" if it accepts the file. Accepted files also become
  // geometry.
  std::string ErrorOfFile(const std::string& path) {
    try {
      const Scene scene = ReadGltf(path);
      if (!scene.meshes.empty()) Geometry(scene, path, 1);
      return "";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
      EXPECT_EQ(error.exit_code(), kExitBadInput) << error.what();
      return error.what();
    }
  }
  std::string ErrorOf(const json& document) {
    return ErrorOfFile(folder_.Write("a.gltf", document.dump()));
  }
  TemporaryFolder folder_;
};

void ExpectNear(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-5) << a.x << " " << a.y << " " << a.z;
}

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
  EXPECT_NE(change("TRANSLATION", "no").find("TRANSLATION is no accessor"), std::string::npos);
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

// yfov is the vertical angle, and ours is that across the shorter side of the film.
TEST_F(Gltf, CamerasOfPortraitsAndWithoutPerspective) {
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
  EXPECT_NEAR(perspective(0.25).fov_degrees, 2 * glm::degrees(std::atan(0.25 * std::tan(0.5))),
              1e-4);
  EXPECT_NEAR(perspective(4).fov_degrees, glm::degrees(1.0), 1e-4);
  const Camera parallel =
      camera({{"type", "orthographic"},
              {"orthographic", {{"xmag", 3.0}, {"ymag", 2.0}, {"znear", 0}, {"zfar", 9}}}});
  EXPECT_EQ(parallel.kind, CameraKind::kOrthographic);
  ASSERT_TRUE(parallel.window);
  EXPECT_EQ(parallel.window->left, -3);
  EXPECT_EQ(parallel.window->right, 3);
  EXPECT_EQ(parallel.window->bottom, -2);
  EXPECT_EQ(parallel.window->top, 2);
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
  // Without any scene, what is nobody's child is shown.
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

// Positions, coordinates of two sets and a number that nobody reads, vertex by vertex in one view.
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
  EXPECT_EQ(scene.images[color.image].rgb, (std::vector<float>{1, 0, 0, 0, 1, 0}));
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
    const std::vector<float>& rgb = scene.images[scene.textures.at(texture.value()).image].rgb;
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
  EXPECT_EQ(Read(document).materials[0].opacity, 1) << "the cutoff is 1/2";
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
  EXPECT_EQ(scene.images[texture.image].rgb, (std::vector<float>{1, 1, 1, 0.2f, 0.2f, 0.2f}));
  EXPECT_TRUE(scene.warnings.empty());
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
  EXPECT_EQ(Read(document).warnings.size(), 1u) << "their alpha";
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
  EXPECT_EQ(Read(document).materials[0].bsdf, BsdfKind::kThinDielectric);
  EXPECT_FLOAT_EQ(Read(document).materials[0].ior, 1.33f);
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
  EXPECT_NE(Read(document).warnings.at(0).find("the normals of the base"), std::string::npos);
  extensions["KHR_materials_clearcoat"]["clearcoatNormalTexture"] = {{"index", 0}};
  EXPECT_TRUE(Read(document).warnings.empty());
  extensions["KHR_materials_clearcoat"]["clearcoatTexture"] = {{"index", 0}};
  EXPECT_NE(Read(document).warnings.at(0).find("clearcoatTexture"), std::string::npos);
  extensions["KHR_materials_clearcoat"] = {{"clearcoatFactor", 0}};
  EXPECT_EQ(Read(document).materials[0].bsdf, BsdfKind::kMetallicRoughness);
  extensions["KHR_materials_sheen"] = {{"sheenColorFactor", {0.1, 0.2, 0.3}},
                                       {"sheenRoughnessFactor", 0.5}};
  const Material velvet = Read(document).materials[0];
  EXPECT_EQ(velvet.bsdf, BsdfKind::kCoatedMetallicRoughness);
  EXPECT_EQ(velvet.coat, 0);
  EXPECT_EQ(velvet.sheen, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_FLOAT_EQ(velvet.sheen_alpha, 0.25f);
  // A quarter of the reflectance at normal incidence is half of the amplitude.
  extensions["KHR_materials_specular"] = {{"specularFactor", 0.25}};
  const float ior = Read(document).materials[0].ior;
  EXPECT_NEAR((ior - 1) / (ior + 1), 0.5 * 0.2, 1e-6);
  EXPECT_EQ(Read(document).warnings, std::vector<std::string>{});
  // A colour stands for its mean, here a half, and multiplies the factor.
  extensions["KHR_materials_specular"] = {{"specularFactor", 0.5},
                                          {"specularColorFactor", {0.75, 0.5, 0.25}}};
  const Scene tinted = Read(document);
  const float weaker = tinted.materials[0].ior;
  EXPECT_NEAR((weaker - 1) / (weaker + 1), 0.5 * 0.2, 1e-6);
  EXPECT_EQ(tinted.warnings.size(), 1u);
  extensions["KHR_materials_specular"]["specularColorFactor"] = {0, 0, 1.5};
  const float blue = Read(document).materials[0].ior;
  EXPECT_NEAR((blue - 1) / (blue + 1), 0.5 * 0.2, 1e-6);
}

TEST_F(Gltf, UnsupportedFeaturesAreNamed) {
  json document = Document();
  document["materials"][0]["extensions"] = {{"KHR_materials_iridescence", json::object()},
                                            {"KHR_materials_variants", json::object()}};
  const std::vector<std::string> warnings = Read(document).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  for (const char* const word : {"KHR_materials_variants", "KHR_materials_iridescence"}) {
    EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [&](const std::string& text) {
      return text.find(word) != std::string::npos;
    })) << word;
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
  refused("/extensionsRequired", {"KHR_draco_mesh_compression"});
  refused("/nodes/1/scale", {std::numeric_limits<double>::max(), 1, 1});
  for (const char* const uri :
       {"../a.png", "/a.png", "missing.png", "a.bin", "data:image/png;base64,AAAA"}) {
    json document = Document();
    document["images"] = {{{"uri", uri}}};
    document["textures"] = {{{"source", 0}}};
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    EXPECT_NE(ErrorOf(document), "") << uri;
  }
  {  // The specification has PNG and JPEG alone.
    WritePfm(folder_.Path("a.pfm"), Image(1, 1));
    json document = Document();
    document["images"] = {{{"uri", "a.pfm"}}};
    document["textures"] = {{{"source", 0}}};
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    EXPECT_NE(ErrorOf(document).find("neither PNG nor JPEG"), std::string::npos);
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
