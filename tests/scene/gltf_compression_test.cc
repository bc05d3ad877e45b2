// Tests compressed geometry in glTF files. Draco and meshopt encode with the libraries themselves,
// so that what is tested is the way of the numbers through the file.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "base/error.h"
#include "scene/gltf/reader.h"
#include "tests/support/expect_near.h"
#include "tests/support/gltf_document.h"

namespace skywave {
namespace {

using nlohmann::json;

Scene Read(const GltfDocument& document, bool strict = false) {
  ReadOptions options;
  options.strict = strict;
  return ParseGltf(document.text(), "a.gltf", options);
}

// Returns two triangles that are a unit square at z = 3, with uvs, as Draco compresses them.
GltfDocument DracoSquare() {
  const float corners[2][3][3] = {{{0, 0, 3}, {1, 0, 3}, {1, 1, 3}},
                                  {{0, 0, 3}, {1, 1, 3}, {0, 1, 3}}};
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uv = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  for (std::uint32_t f = 0; f < 2; ++f) {
    const auto& c = corners[f];
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(f), c[0], c[1], c[2]);
    builder.SetAttributeValuesForFace(uv, draco::FaceIndex(f), c[0], c[1], c[2]);
  }
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());

  GltfDocument document;
  const int view =
      document.AddView(std::vector<std::int8_t>(buffer.data(), buffer.data() + buffer.size()));
  document.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  document.json["accessors"] = {{{"componentType", 5126}, {"count", 400}, {"type", "VEC3"}},
                                {{"componentType", 5126}, {"count", 400}, {"type", "VEC2"}},
                                {{"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}}};
  document.json["scenes"] = {{{"nodes", {0}}}};
  document.json["nodes"] = {{{"mesh", 0}}};
  document.json["meshes"] = {
      {{"name", "square"},
       {"primitives",
        {{{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}},
          {"indices", 2},
          {"extensions",
           {{"KHR_draco_mesh_compression",
             {{"bufferView", view},
              {"attributes", {{"POSITION", position}, {"TEXCOORD_0", uv}}}}}}}}}}}};
  return document;
}

TEST(GltfCompression, DracoIsDecoded) {
  const Scene scene = Read(DracoSquare());
  EXPECT_TRUE(scene.warnings.empty());
  const Mesh& mesh = scene.meshes.at(0);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  double area = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    EXPECT_NEAR(glm::normalize(glm::cross(b - a, c - a)).z, 1, 1e-6);
    area += 0.5 * double(glm::length(glm::cross(b - a, c - a)));
  }
  EXPECT_NEAR(area, 1, 1e-6);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_NEAR(mesh.positions[i].z, 3, 1e-6);
    EXPECT_NEAR(mesh.uvs[i].x, mesh.positions[i].x, 1e-3) << "the points of both attributes agree";
    EXPECT_NEAR(mesh.uvs[i].y, mesh.positions[i].y, 1e-3);
  }
}

// A primitive that cannot be decoded is left out by name, and the others stay.
TEST(GltfCompression, BrokenDracoIsLeftOut) {
  GltfDocument document = DracoSquare();
  json& primitives = document.json["meshes"][0]["primitives"];
  json broken = primitives[0];
  broken["extensions"]["KHR_draco_mesh_compression"]["bufferView"] =
      document.AddView(std::vector<std::int8_t>(40, 1));
  primitives.push_back(broken);
  for (const json& view : {json(17), json("x"), json(-1)}) {
    primitives.push_back(broken);
    primitives.back()["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = view;
  }
  primitives.push_back(primitives[0]);
  primitives.back()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 9;
  const Scene scene = Read(document);
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_FALSE(scene.warnings.empty());
  EXPECT_NE(scene.warnings[0].find("'square'"), std::string::npos) << scene.warnings[0];
  EXPECT_NE(scene.warnings[0].find("KHR_draco"), std::string::npos) << scene.warnings[0];
  EXPECT_THROW(Read(document, true), InputError);
}

// Returns a triangle whose positions and indices are compressed by meshopt. Their uncompressed
// buffer does not exist.
GltfDocument MeshoptTriangle(const std::string& name = "EXT_meshopt_compression") {
  const std::vector<float> positions = {0, 0, 0, 2, 0, 0, 0, 2, 0};
  const std::vector<std::uint32_t> indices = {0, 1, 2};
  std::vector<std::uint8_t> vertices(meshopt_encodeVertexBufferBound(3, 12));
  vertices.resize(
      meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), positions.data(), 3, 12));
  std::vector<std::uint8_t> corners(meshopt_encodeIndexBufferBound(3, 3));
  corners.resize(meshopt_encodeIndexBuffer(corners.data(), corners.size(), indices.data(), 3));
  GltfDocument document;
  const int views[] = {document.AddView(vertices), document.AddView(corners)};
  const auto compress = [&](int view, int stride, const char* mode) {
    json& whole = document.json["bufferViews"][std::size_t(view)];
    json extension = whole;
    extension["byteStride"] = stride, extension["count"] = 3, extension["mode"] = mode;
    whole = {{"buffer", 0}, {"byteLength", 3 * stride}, {"extensions", {{name, extension}}}};
  };
  compress(views[0], 12, "ATTRIBUTES"), compress(views[1], 4, "TRIANGLES");
  document.json["extensionsRequired"] = {name};
  document.json["accessors"] = {
      {{"bufferView", views[0]}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
      {{"bufferView", views[1]}, {"componentType", 5125}, {"count", 3}, {"type", "SCALAR"}}};
  document.json["scenes"] = {{{"nodes", {0}}}};
  document.json["nodes"] = {{{"mesh", 0}}};
  document.json["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}};
  return document;
}

TEST(GltfCompression, MeshoptIsDecoded) {
  for (const char* const name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    SCOPED_TRACE(name);
    const Scene scene = Read(MeshoptTriangle(name));
    EXPECT_TRUE(scene.warnings.empty());
    const Mesh& mesh = scene.meshes.at(0);
    EXPECT_EQ(mesh.positions,
              (std::vector<glm::vec3>{glm::vec3(0), glm::vec3(2, 0, 0), glm::vec3(0, 2, 0)}));
    ASSERT_EQ(mesh.triangles.size(), 1u);
    const glm::uvec3 t = mesh.triangles[0];
    EXPECT_EQ(t.x + 4 * t.y + 16 * t.z, 36u) << "in any turn: 0 1 2, and not 0 2 1";
  }
}

// Gives the triangle an attribute of three elements that are compressed with a filter.
void AddFiltered(GltfDocument& document, const char* attribute, const json& accessor,
                 const std::string& extension_name, const char* filter, const void* elements,
                 std::size_t stride) {
  std::vector<std::uint8_t> bytes(meshopt_encodeVertexBufferBound(3, stride));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), elements, 3, stride));
  const int view = document.AddView(bytes);
  json& whole = document.json["bufferViews"][std::size_t(view)];
  json extension = whole;
  extension["byteStride"] = stride, extension["count"] = 3, extension["mode"] = "ATTRIBUTES";
  extension["filter"] = filter;
  whole["extensions"][extension_name] = extension;
  whole["byteLength"] = 3 * stride, whole["byteStride"] = stride;
  json& accessors = document.json["accessors"];
  document.json["meshes"][0]["primitives"][0]["attributes"][attribute] = accessors.size();
  accessors.push_back(accessor);
  accessors.back()["bufferView"] = view, accessors.back()["count"] = 3;
}

// Returns what reading says, warnings or the error.
std::string Said(const GltfDocument& document) {
  try {
    std::string all;
    for (const std::string& line : Read(document).warnings) all += line;
    return all;
  } catch (const InputError& error) {
    return error.what();
  }
}

// Luma, differences and alpha with 8, 4 and 1 bits, worked out by hand (KHR_meshopt_compression,
// Appendix B, filter 4).
TEST(GltfCompression, MeshoptColorsAreRgb) {
  const auto expect = [](const auto& encoded, int component, const glm::vec3(&rgb)[3]) {
    const char* const name = "KHR_meshopt_compression";
    GltfDocument document = MeshoptTriangle(name);
    AddFiltered(document, "COLOR_0",
                {{"componentType", component}, {"normalized", true}, {"type", "VEC4"}}, name,
                "COLOR", encoded, sizeof encoded / 3);
    const Mesh mesh = Read(document).meshes.at(0);
    ASSERT_EQ(mesh.colors.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) ExpectNear(glm::vec3(mesh.colors[i]), rgb[i], 1e-6f);
  };
  const std::uint8_t eight[] = {110, 80, 246, 0xff, 8, 4, 253, 0b1010, 1, 0, 0, 1};
  expect(eight, 5121,
         {glm::vec3(200, 100, 40) / 255.0f, glm::vec3(15, 5, 7) / 15.0f, glm::vec3(1)});
  const std::uint16_t sixteen[] = {110, 80, 65526, 0xff, 8, 4, 65533, 0b1010, 1, 0, 0, 1};
  expect(sixteen, 5123,
         {glm::vec3(200, 100, 40) / 255.0f, glm::vec3(15, 5, 7) / 15.0f, glm::vec3(1)});
}

// What the library does not know yet is not called broken.
TEST(GltfCompression, ANewerCodecOfMeshoptIsNamed) {
  GltfDocument document = MeshoptTriangle("KHR_meshopt_compression");
  const json& view = document.json["bufferViews"][0]["extensions"]["KHR_meshopt_compression"];
  document.bytes[view["byteOffset"].get<std::size_t>()] = '\xa1';
  const std::string said = Said(document);
  EXPECT_EQ(said.find("version 1 of the codec") != std::string::npos, MESHOPTIMIZER_VERSION < 230)
      << said;
}

// Octahedral normals of eight bits are unit vectors after their filter (EXT_meshopt_compression).
TEST(GltfCompression, MeshoptFiltersAreApplied) {
  GltfDocument document = MeshoptTriangle();
  const std::vector<float> normals = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0};
  std::vector<std::uint8_t> octahedral(4 * 3);
  meshopt_encodeFilterOct(octahedral.data(), 3, 4, 8, normals.data());
  AddFiltered(document, "NORMAL", {{"componentType", 5120}, {"normalized", true}, {"type", "VEC3"}},
              "EXT_meshopt_compression", "OCTAHEDRAL", octahedral.data(), 4);
  const Mesh mesh = Read(document).meshes.at(0);
  EXPECT_NEAR(mesh.normals[0].z, 1, 1e-2);
  EXPECT_NEAR(mesh.normals[1].y, 1, 1e-2);
  EXPECT_NEAR(mesh.normals[2].x, 1, 1e-2);
}

TEST(GltfCompression, BrokenMeshoptIsNamed) {
  const auto warnings = [](const char* member, const json& value) {
    GltfDocument document = MeshoptTriangle();
    document.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][member] = value;
    return Said(document);
  };
  for (const auto& [member, value] :
       std::vector<std::pair<const char*, json>>{{"count", 400},
                                                 {"count", 1u << 30},
                                                 {"byteStride", 6},
                                                 {"byteStride", 0},
                                                 {"mode", "LINES"},
                                                 {"filter", "SHARP"},
                                                 {"byteLength", 5},
                                                 {"byteOffset", 1000}}) {
    EXPECT_NE(warnings(member, value), "") << member << " = " << value;
  }
}

}  // namespace
}  // namespace skywave
