// Tests glTF files: the scenes they become, and everything that is refused.
#include "scene/gltf/reader.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "image/image.h"
#include "tests/support/gltf_document.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

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
  const CompactImage& image = scene.images[scene.textures.at(0).image];
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
  document["asset"]["version"] = 1.0;
  EXPECT_NE(ErrorOf(document).find("glTF 1.0"), std::string::npos) << "also as a number";
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

TEST_F(Gltf, NamesInWarningsHoldNoControlCodes) {
  json document = Document();
  document["meshes"][0]["name"] =
      "\x1b[31m\xc2\x9b"
      "red";
  document["meshes"][0]["primitives"][0]["attributes"].erase("POSITION");
  const Scene scene = Read(document);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("'?[31m?red'"), std::string::npos) << scene.warnings[0];
}

// A container whose length is less than that of its header has no chunks to look for.
TEST_F(Gltf, AContainerIsAsLongAsItsHeader) {
  std::string file = Glb(Document(), Buffer());
  for (const char length : {0, 5, 11}) {
    file[8] = length, file[9] = file[10] = file[11] = 0;
    EXPECT_NE(ErrorOfFile(folder_.Write("a.glb", file)).find("header included"), std::string::npos)
        << int(length);
  }
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
