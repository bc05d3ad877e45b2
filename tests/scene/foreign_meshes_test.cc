// OBJ, MTL and PLY as other programs write them: what is missing or unknown in them is named, and
// the rest is rendered.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "image/image.h"
#include "scene/obj/reader.h"
#include "scene/reader.h"
#include "scene/shapes/ply.h"
#include "tests/support/expect_near.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

const std::string kTriangle = "v -1 0 0\nv 1 0 0\nv 0 1 0\n";

Scene Parse(const std::string& text) { return ParseObj(text, "t.obj"); }

std::size_t Triangles(const Scene& scene) {
  std::size_t count = 0;
  for (const Mesh& mesh : scene.meshes) count += mesh.triangles.size();
  return count;
}

// Each text has one triangle and one warning, whose text comes second.
TEST(ForeignObj, WhatCannotBeReadIsNamedAndTheRestIsRendered) {
  const std::pair<std::string, std::string> cases[] = {
      {"mtllib no.mtl\nf 1 2 3\n", "t.obj:4: mtllib: there is no file \"no.mtl\""},
      {"mtllib\nf 1 2 3\n", "t.obj:4: 'mtllib' without a name"},
      {"usemtl\nf 1 2 3\n", "t.obj:4: 'usemtl' without a name"},
      {"f 1 2\nf 1 2 3\n", "t.obj:4: a face of fewer than three corners"},
      {"f\nf 1 2 3\n", "t.obj:4: a face of fewer than three corners"},
      {"t crease 99999999/1/1\nf 1 2 3\n", "t.obj:4: 't' is not a statement of OBJ"},
      {"vw 1 2 3\nf 1 2 3\n", "t.obj:4: 'vw' is not a statement of OBJ"},
      {"f 1/1 2/1 3/1\n", "t.obj:4: faces have texture vertex indices"},
      {"f 1//1 2//1 3//1\n", "t.obj:4: faces have normal indices"}};
  for (const auto& [text, warning] : cases) {
    const Scene scene = Parse(kTriangle + text);
    EXPECT_EQ(Triangles(scene), 1u) << text;
    ASSERT_EQ(scene.warnings.size(), 1u) << text;
    EXPECT_TRUE(scene.warnings[0].starts_with(warning)) << scene.warnings[0];
  }
  // Indices of what is there stay, beside those of what is not.
  const Scene normal = Parse(kTriangle + "vn 0 0 -1\nf 1/7/1 2/8/1 3/9/1\n");
  ASSERT_EQ(normal.meshes.at(0).normals.size(), 3u);
  ExpectNear(normal.meshes[0].normals[0], {0, 0, -1});
}

TEST(ForeignObj, CommentsSlashesAndByteOrderMarksDoNoHarm) {
  for (const std::string text : {"f 1/1/ 2/2/ 3/3/\n", "f 1/1 2/2 3/3 # a face\n",
                                 "f 1/1 2/2 3/3 #4/4\n", "f 1/1 2/2 3/3/\n"}) {
    const Scene scene = Parse("\xEF\xBB\xBF" + kTriangle + "vt 0 0\nvt 1 0\nvt 1 .5\n" + text);
    ASSERT_EQ(Triangles(scene), 1u) << text;
    ASSERT_EQ(scene.meshes[0].uvs.size(), 3u) << text;
    EXPECT_EQ(scene.meshes[0].uvs[2], glm::vec2(1, 0.5f)) << text;
    EXPECT_TRUE(scene.warnings.empty()) << text;
  }
  const TemporaryFolder folder;
  folder.Write("a.mtl", "\xEF\xBB\xBFnewmtl #1 white\n  Kd .2 .4 .6 #there's a comment\n");
  const Scene scene =
      ReadScene(folder.Write("a.obj", "mtllib a.mtl\n" + kTriangle + "usemtl #1 white\nf 1 2 3\n"));
  EXPECT_TRUE(scene.warnings.empty());
  ExpectNear(scene.materials.at(scene.meshes.at(0).material).reflectance, {0.2f, 0.4f, 0.6f});
}

TEST(ForeignObj, NamesOfLibrariesMayHaveBackslashesBeforeBlanks) {
  const TemporaryFolder folder;
  folder.Write("a b c.mtl", "newmtl red\nKd 1 0 0\n");
  const Scene scene = ReadScene(
      folder.Write("a.obj", "mtllib a\\ b\\ c.mtl\n" + kTriangle + "usemtl red\nf 1 2 3\n"));
  EXPECT_TRUE(scene.warnings.empty());
  ExpectNear(scene.materials.at(scene.meshes.at(0).material).reflectance, {1, 0, 0});
}

// Names of materials hold the sign of comments.
TEST(ForeignObj, NamesMayHoldTheSignOfComments) {
  const TemporaryFolder folder;
  folder.Write("a.mtl", "newmtl Material #25\nKd 1 0 0\nnewmtl Paint\nKd 0 0 1\n");
  const Scene scene =
      ReadScene(folder.Write("a.obj", "mtllib a.mtl\n" + kTriangle +
                                          "usemtl Material #25\nf 1 2 3\nusemtl Paint\nf 3 2 1\n"));
  EXPECT_TRUE(scene.warnings.empty());
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.materials.at(scene.meshes[0].material).name, "Material #25");
  EXPECT_EQ(scene.materials.at(scene.meshes[1].material).reflectance, glm::vec3(0, 0, 1));
}

// sRGB of 0.5 is 0.21404 in linear light. Without a material the colours are the reflectance.
TEST(ForeignObj, ColoursOfVerticesAreRead) {
  const Scene scene = Parse("v -1 0 0 1 0 0\nv 1 0 0 0 1 .5\nv 0 1 0 0 0 1\nf 1 2 3\n");
  ASSERT_EQ(scene.meshes.at(0).colors.size(), 3u);
  ExpectNear(scene.meshes[0].colors[0], {1, 0, 0});
  ExpectNear(scene.meshes[0].colors[1], {0, 1, 0.21404f});
  EXPECT_EQ(scene.materials.at(0).reflectance, glm::vec3(1));
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(Parse(kTriangle + "f 1 2 3\n").meshes.at(0).colors.empty());
}

TEST(ForeignMtl, DissolveIsOpacityAndNoGlass) {
  const TemporaryFolder folder;
  const auto material = [&](const std::string& statements) {
    folder.Write("a.mtl", "newmtl a\n" + statements);
    const Scene scene =
        ReadScene(folder.Write("a.obj", "mtllib a.mtl\nusemtl a\n" + kTriangle + "f 1 2 3\n"));
    return std::pair(scene.materials.at(scene.meshes.at(0).material), scene.warnings);
  };
  for (const float d : {0.1f, 0.3f, 0.49f, 0.5f, 0.9f}) {
    const auto [clear, warnings] = material("Kd 0 0 0\nillum 2\nd " + std::to_string(d) + "\n");
    EXPECT_EQ(clear.bsdf, BsdfKind::kLambert);
    EXPECT_FLOAT_EQ(clear.opacity, d);
    EXPECT_TRUE(warnings.empty());
  }
  EXPECT_FLOAT_EQ(material("Tr 0.75\n").first.opacity, 0.25f);
  const auto [meshlab, warnings] = material("Tr 1.000000\nillum 2\n");
  EXPECT_EQ(meshlab.opacity, 1);
  EXPECT_EQ(warnings.size(), 1u);
}

TEST(ForeignMtl, ImagesThatCannotBeReadAreNamed) {
  const TemporaryFolder folder;
  folder.Write("t.dds", "DDS |");
  for (const std::string word : {"map_Kd", "map_Ke", "map_d", "bump", "norm"}) {
    folder.Write("a.mtl", "newmtl a\n" + word + " t.dds\n");
    const Scene scene =
        ReadScene(folder.Write("a.obj", "mtllib a.mtl\nusemtl a\n" + kTriangle + "f 1 2 3\n"));
    EXPECT_EQ(Triangles(scene), 1u);
    ASSERT_EQ(scene.warnings.size(), 1u) << word;
    EXPECT_NE(scene.warnings[0].find("a.mtl:2: " + word + ": "), std::string::npos)
        << scene.warnings[0];
    EXPECT_NE(scene.warnings[0].find("DDS"), std::string::npos) << scene.warnings[0];
  }
}

std::string Ply(const std::string& vertex, const std::string& face, const std::string& data,
                int vertices = 4, const std::string& comment = "") {
  return "ply\nformat ascii 1.0\n" + comment + "element vertex " + std::to_string(vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\n" + vertex + face +
         "end_header\n" + data;
}
const std::string kFace = "element face 1\nproperty list uchar int vertex_indices\n";

TEST(ForeignPly, ColoursOfVerticesAreRead) {
  const std::string of_bytes =
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  const Mesh mesh = ParsePly(
      Ply(of_bytes, kFace, "0 0 0 255 0 0 255\n1 0 0 0 188 0 255\n0 1 0 0 0 0 9\n3 0 1 2\n", 3),
      "t.ply");
  ASSERT_EQ(mesh.colors.size(), 3u);
  ExpectNear(mesh.colors[0], {1, 0, 0});
  EXPECT_NEAR(mesh.colors[1].y, 0.50289f, 1e-4f);
  const std::string of_floats =
      "property float diffuse_red\nproperty float diffuse_green\nproperty float diffuse_blue\n";
  const Mesh bright = ParsePly(
      Ply(of_floats, kFace, "0 0 0 1 .5 0\n1 0 0 2 0 0\n0 1 0 0 0 0\n3 0 1 2\n", 3), "t.ply");
  ExpectNear(bright.colors.at(0), {1, 0.21404f, 0});
  ExpectNear(bright.colors.at(1), {1, 0, 0});
}

TEST(ForeignPly, LinesOfHeadersThatAreNoStatementsAreNamed) {
  PlyReport report;
  const Mesh mesh = ParsePly(
      Ply("", kFace, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", 3, "Created by hand\n"), "t.ply", &report);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  Warnings warnings;
  WarnOfPly(report, InputPosition::File("t.ply"), warnings);
  EXPECT_EQ(WarningLines(warnings),
            std::vector<std::string>{
                "t.ply: 'Created' is not a statement of a PLY header: its line is ignored"});
}

// Four vertices of a strip are two triangles; after -1 another strip begins. All face +z.
TEST(ForeignPly, StripsOfTrianglesAreRead) {
  const std::string strips = "element tristrips 1\nproperty list int int vertex_indices\n";
  const Mesh mesh =
      ParsePly(Ply("", strips, "0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 2\n"), "t.ply");
  ASSERT_EQ(mesh.triangles.size(), 3u);
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    EXPECT_GT(glm::cross(b - a, c - a).z, 0);
  }
}

TEST(ForeignPly, SignsSmallFacesAndTrailingBytesDoNoHarm) {
  const std::string two_faces = "element face 2\nproperty list uchar int vertex_indices\n";
  PlyReport report;
  const Mesh mesh = ParsePly(
      Ply("", two_faces, "+0.5 0 0\n1 0 0\n0 +1 0\n2 0 1\n3 0 1 2\nmore\n", 3), "t.ply", &report);
  EXPECT_EQ(mesh.positions[0].x, 0.5f);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(report.small_faces, 1u);
  EXPECT_EQ(report.trailing_bytes, 5u);
  Warnings warnings;
  WarnOfPly(report, InputPosition::File("t.ply"), warnings);
  EXPECT_EQ(WarningLines(warnings).size(), 2u);
}

// MeshLab names the texture in a comment and writes coordinates for the corners of faces.
TEST(ForeignPly, TexturesOfMeshlabAreRead) {
  const TemporaryFolder folder;
  WritePng(folder.Path("t.png"), 2, 1, {255, 0, 0, 0, 0, 255});
  const std::string face =
      "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float "
      "texcoord\n";
  const std::string text =
      Ply("", face, "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 6 0 0 .5 0 0 .5\n3 1 3 2 6 1 0 1 1 .5 1\n",
          4, "comment TextureFile t.png\n");
  const Scene scene = ReadScene(folder.Write("a.ply", text));
  EXPECT_TRUE(scene.warnings.empty());
  const Mesh& mesh = scene.meshes.at(0);
  ASSERT_EQ(mesh.uvs.size(), 6u);
  EXPECT_EQ(mesh.uvs[mesh.triangles[0].y], glm::vec2(0.5f, 0));
  EXPECT_EQ(mesh.uvs[mesh.triangles[1].x], glm::vec2(1, 0));
  EXPECT_EQ(mesh.positions[mesh.triangles[1].x], glm::vec3(1, 0, 0));
  ASSERT_TRUE(scene.materials.at(0).color_texture);
  // The file was moved, and the texture beside it.
  std::string moved = text;
  moved.replace(moved.find("t.png"), 5, "C:\\scans\\t.png");
  const Scene beside = ReadScene(folder.Write("c.ply", moved));
  EXPECT_TRUE(beside.warnings.empty());
  EXPECT_TRUE(beside.materials.at(0).color_texture);
  std::string missing = text;
  missing.replace(missing.find("t.png"), 5, "u.png");
  const Scene without = ReadScene(folder.Write("b.ply", missing));
  EXPECT_EQ(without.warnings.size(), 1u);
  EXPECT_FALSE(without.materials.at(0).color_texture);
}

TEST(ForeignPbrt, AByteOrderMarkIsNoWord) {
  const TemporaryFolder folder;
  const Scene scene =
      ReadScene(folder.Write("a.pbrt", "\xEF\xBB\xBFWorldBegin\nShape \"sphere\"\n"));
  EXPECT_EQ(Triangles(scene), 20480u);
}

}  // namespace
}  // namespace skywave
