// Tests OBJ files and their material libraries: faces, normals, smoothing, and materials computed
// by hand.
#include "scene/obj/reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "image/image.h"
#include "scene/obj/mtl.h"
#include "scene/reader.h"
#include "scene/shapes/smooth_normals.h"
#include "tests/support/expect_near.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

Scene Parse(const std::string& text) { return ParseObj(text, "t.obj"); }

std::vector<Material> Materials(const std::string& text, Warnings& warnings) {
  Scene scene;
  TextureFiles textures{&scene};
  return ParseMtl(text, "t.mtl", textures, warnings);
}
Material OnlyMaterial(const std::string& statements) {
  Warnings warnings;
  return Materials("newmtl m\n" + statements, warnings).at(0);
}
std::vector<std::string> MtlWarnings(const std::string& text) {
  Warnings warnings;
  Materials(text, warnings);
  return WarningLines(warnings);
}

std::size_t Triangles(const Scene& scene) {
  std::size_t count = 0;
  for (const Mesh& mesh : scene.meshes) count += mesh.triangles.size();
  return count;
}

double Area(const Scene& scene) {
  double area = 0;
  for (const Mesh& mesh : scene.meshes) {
    for (const glm::uvec3& t : mesh.triangles) {
      area += 0.5 * glm::length(glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                           mesh.positions[t.z] - mesh.positions[t.x]));
    }
  }
  return area;
}

constexpr char kSquare[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, FacesOfEveryFormAreRead) {
  for (const char* face :
       {"f 1 2 3 4", "f -4 -3 -2 -1", "f 1/1 2/2 3/3 4/4", "f 1//1 2//1 3//1 4//1",
        "f 1/1/1 2/2/1 3/3/1 4/4/-1", "  f\t1  2 3   4  ", "f 1 2 \\\n 3 4", "f 1 2 3\nf 1 3 4"}) {
    SCOPED_TRACE(face);
    const Scene scene =
        Parse(std::string(kSquare) + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\n" + face + "\n");
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 2u);
    EXPECT_EQ(scene.meshes[0].positions.size(), 4u);
    EXPECT_NEAR(Area(scene), 1, 1e-6);
    ASSERT_EQ(scene.meshes[0].normals.size(), 4u);
    ExpectNear(scene.meshes[0].normals[0], {0, 0, 1});
    EXPECT_FALSE(scene.left_handed);
    EXPECT_EQ(scene.up_axis, 'y');
    EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  }
  // The text has every kind of line end, comments, numbers with a plus, and weights and colours of
  // vertices.
  for (const char* end : {"\n", "\r\n", "\r"}) {
    std::string text =
        "# a comment\n\nv +0 0 0 1\nv 1e0 0 .0 0.5 0.5 0.5\nv 1 1. 0\nv 0 1 0\nf 1 2 3 4";
    for (std::size_t i; (i = text.find('\n')) != std::string::npos;) text.replace(i, 1, "@");
    for (std::size_t i; (i = text.find('@')) != std::string::npos;) text.replace(i, 1, end);
    EXPECT_NEAR(Area(Parse(text)), 1, 1e-6);
  }
  // The polygon is an L: it must be cut into ears, not into a fan.
  EXPECT_NEAR(Area(Parse("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 3 4 5 6 1 2\n")),
              3, 1e-6);
}

TEST(Obj, TextureCoordinatesSplitVertices) {
  const Scene scene = Parse(std::string(kSquare) +
                            "vt 0 0\nvt 1 0\nvt 1 1\nvt .5 .5\nf 1/1 2/2 3/3\nf 1/4 3/3 4/1\n");
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.positions.size(), 5u);  // corner 1 occurs twice
  EXPECT_EQ(mesh.uvs.size(), 5u);
  EXPECT_EQ(mesh.uvs[mesh.triangles[1].x], glm::vec2(0.5f, 0.5f));
}

// Returns two squares that meet at an angle along the edge x = 1.
std::string Fold(double degrees, const std::string& before_faces) {
  const double a = degrees * 3.14159265358979 / 180;
  const std::string x = std::to_string(1 + std::cos(a)), z = std::to_string(-std::sin(a));
  return std::string(kSquare) + "v " + x + " 0 " + z + "\nv " + x + " 1 " + z + "\n" +
         before_faces + "f 1 2 3 4\nf 2 5 6 3\n";
}

TEST(Obj, SmoothingGroupsDecideWhereThereAreNoNormals) {
  // At 90 degrees in one group, the edge is smooth.
  const Scene smooth = Parse(Fold(90, "s 1\n"));
  ASSERT_EQ(smooth.meshes.size(), 1u);
  EXPECT_EQ(smooth.meshes[0].positions.size(), 6u);
  const float half = std::sqrt(0.5f);
  bool found = false;
  for (std::size_t i = 0; i < smooth.meshes[0].positions.size(); ++i) {
    if (smooth.meshes[0].positions[i] != glm::vec3(1, 0, 0)) continue;
    ExpectNear(smooth.meshes[0].normals[i], {half, 0, half});
    found = true;
  }
  EXPECT_TRUE(found);
  // With smoothing off there are no normals at all, and 10 degrees are an edge.
  for (const char* off : {"s off\n", "s 0\n"}) {
    const Scene flat = Parse(Fold(10, off));
    ASSERT_EQ(flat.meshes.size(), 1u);
    EXPECT_TRUE(flat.meshes[0].normals.empty());
  }
  // Two groups are smooth each, with an edge between them.
  std::string two = Fold(10, "s 1\n");
  two.insert(two.find("f 2 5"), "s 2\n");
  EXPECT_EQ(Parse(two).meshes.at(0).positions.size(), 8u);
  // With smoothing off for one of them, there are two meshes, one of them flat.
  std::string mixed = Fold(10, "s 1\n");
  mixed.insert(mixed.find("f 2 5"), "s off\n");
  const Scene both = Parse(mixed);
  ASSERT_EQ(both.meshes.size(), 2u);
  EXPECT_NE(both.meshes[0].normals.empty(), both.meshes[1].normals.empty());
}

TEST(Obj, WithoutSmoothingGroupsCreasesStay) {
  EXPECT_EQ(Parse(Fold(kCreaseDegrees - 1, "")).meshes.at(0).positions.size(), 6u);
  const Scene sharp = Parse(Fold(kCreaseDegrees + 1, ""));
  EXPECT_EQ(sharp.meshes.at(0).positions.size(), 8u);
  for (const glm::vec3& n : sharp.meshes[0].normals) EXPECT_NEAR(glm::length(n), 1, 1e-6);
  ExpectNear(sharp.meshes[0].normals[sharp.meshes[0].triangles[0].x], {0, 0, 1});
}

TEST(Obj, NormalsOfTheFileComeFirst) {
  // The second face has no normals, so it is smooth up to its crease; the first keeps those of the
  // file.
  const Scene scene = Parse(std::string(kSquare) + "vn 0 1 1\nf 1//1 2//1 3//1\nf 1 3 4\n");
  const Mesh& mesh = scene.meshes.at(0);
  ExpectNear(mesh.normals[mesh.triangles[0].x], glm::normalize(glm::vec3(0, 1, 1)));
  ExpectNear(mesh.normals[mesh.triangles[1].x], {0, 0, 1});
  // Normals take precedence over the winding.
  const Mesh against = Parse(std::string(kSquare) + "vn 0 0 -1\nf 1//1 2//1 3//1\n").meshes.at(0);
  const glm::uvec3 t = against.triangles[0];
  EXPECT_LT(glm::cross(against.positions[t.y] - against.positions[t.x],
                       against.positions[t.z] - against.positions[t.x])
                .z,
            0);
}

// The normals of corners are those that they name, in any order.
TEST(Obj, EveryCornerHasItsOwnNormal) {
  const Scene scene = Parse(std::string(kSquare) +
                            "vn 0 0 1\nvn 0 .6 .8\nvn .8 0 .6\nvn -.6 0 .8\n"
                            "f 1//3 2//1 3//4\nf 1//3 3//2 4//1\n");
  const Mesh& mesh = scene.meshes.at(0);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  const glm::vec3 expected[] = {{0.8f, 0, 0.6f}, {0, 0, 1},       {-0.6f, 0, 0.8f},
                                {0.8f, 0, 0.6f}, {0, 0.6f, 0.8f}, {0, 0, 1}};
  for (int corner = 0; corner < 6; ++corner) {
    SCOPED_TRACE(corner);
    ExpectNear(mesh.normals.at(mesh.triangles[std::size_t(corner / 3)][corner % 3]),
               expected[corner]);
  }
}

// Three sides of a cube meet evenly, though one of them is cut in two there.
TEST(Obj, SmoothNormalsDoNotShowHowFacesAreCut) {
  const Mesh mesh = Parse(
                        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\ns 1\n"
                        "f 1 4 3\nf 1 3 2\nf 1 2 5\nf 1 5 4\n")
                        .meshes.at(0);
  ExpectNear(mesh.normals.at(mesh.triangles.at(0).x), glm::vec3(-std::sqrt(1 / 3.0f)));
}

TEST(Obj, AFanOfManyTrianglesIsReadQuickly) {
  std::string text = "v 0 0 0\n";
  constexpr int kSides = 20000;
  for (int i = 0; i < kSides; ++i) {
    const double a = 2 * 3.14159265358979 * i / kSides;
    text += "v " + std::to_string(std::cos(a)) + " " + std::to_string(std::sin(a)) + " 0\n";
  }
  for (int i = 0; i < kSides; ++i) {
    text += "f 1 " + std::to_string(i + 2) + " " + std::to_string((i + 1) % kSides + 2) + "\n";
  }
  EXPECT_EQ(Triangles(Parse(text)), std::size_t{kSides});
}

TEST(Obj, MaterialsMakeMeshes) {
  const TemporaryFolder folder;
  folder.Write("a library.mtl", "newmtl red\nKd 1 0 0\nnewmtl two words\nKd 0 1 0\n");
  folder.Write("b.mtl", "newmtl blue\nKd 0 0 1\nnewmtl red\nKd 0 0 0\n");
  const Scene scene = ReadScene(folder.Write(
      "m.OBJ", std::string(kSquare) +
                   "f 1 2 3\nusemtl red\nf 1 3 4\nmtllib a library.mtl\nmtllib b.mtl\n"
                   "usemtl two words\nf 1 2 4\nusemtl red\ng next\nf 2 3 4\nusemtl blue\nf 4 3 2\n"
                   "usemtl green\nf 3 2 1\nusemtl green\nf 3 2 1\n"));
  ASSERT_EQ(scene.meshes.size(), 4u);
  const auto color = [&](int i) { return scene.materials[scene.meshes[i].material].reflectance; };
  EXPECT_EQ(scene.meshes[0].triangles.size(), 3u);  // one without a material, and one that no
                                                    // library defines
  ExpectNear(color(0), glm::vec3(0.5f));
  EXPECT_EQ(scene.meshes[1].name, "red");
  EXPECT_EQ(scene.meshes[1].triangles.size(), 2u);
  ExpectNear(color(1), {1, 0, 0});
  ExpectNear(color(2), {0, 1, 0});
  ExpectNear(color(3), {0, 0, 1});
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(scene.warnings[0].ends_with(
      "m.OBJ:17: no material \"green\" is in a library: grey Lambert is used"))
      << scene.warnings[0];
}

TEST(Obj, OtherStatementsAreNamedOnce) {
  const Scene scene = Parse(std::string(kSquare) + "l 1 2\nl 2 3\nf 1 2 3\ncstype bezier\no x\n");
  EXPECT_EQ(scene.warnings,
            (std::vector<std::string>{
                "t.obj:8: 'cstype' is not supported: left out",
                "t.obj:5: points and lines are left out: `point-size 1` shows them"}));
}

TEST(Mtl, LambertIsTheDefault) {
  const Material plain = OnlyMaterial("Kd .1 .2 .3\nNs 50\nNi 1.5\nd 1\nillum 2\nKs 0 0 0\n");
  EXPECT_EQ(plain.bsdf, BsdfKind::kLambert);
  EXPECT_EQ(plain.name, "m");
  ExpectNear(plain.reflectance, {0.1f, 0.2f, 0.3f});
  ExpectNear(OnlyMaterial("Kd .3").reflectance, glm::vec3(0.3f));
  ExpectNear(OnlyMaterial("").reflectance, glm::vec3(0.5f));
  EXPECT_EQ(OnlyMaterial("Kd 0 0 0").bsdf, BsdfKind::kLambert);
  ExpectNear(OnlyMaterial("Kd 0 0 0").reflectance, glm::vec3(0));
  const Material coated = OnlyMaterial("Kd .5 .5 .5\nKs .3 .3 .3\nNs 98");
  EXPECT_EQ(coated.bsdf, BsdfKind::kMetallicRoughness);
  EXPECT_NEAR(coated.alpha, std::sqrt(0.02), 1e-6);
  EXPECT_EQ(coated.metallic, 0);
}

TEST(Mtl, MetalsMirrorsAndGlassAreRecognised) {
  const Material metal = OnlyMaterial("Kd 0 0 0\nKs .2 .5 .8\nNs 98\nillum 2");
  EXPECT_EQ(metal.bsdf, BsdfKind::kConductor);
  EXPECT_NEAR(metal.alpha, std::sqrt(2.0 / 100), 1e-6);
  // eta = 1 gives F0 = k^2 / (4 + k^2).
  ExpectNear(metal.k * metal.k / (4.0f + metal.k * metal.k), {0.2f, 0.5f, 0.8f});
  for (const char* illum : {"illum 3", "illum 5"}) {
    const Material mirror = OnlyMaterial(std::string("Kd 0 0 0\nKs .9 .8 .7\n") + illum);
    EXPECT_EQ(mirror.bsdf, BsdfKind::kMirror);
    ExpectNear(mirror.reflectance, {0.9f, 0.8f, 0.7f});
  }
  for (const char* glass :
       {"illum 7\nNi 1.33", "illum 4\nTf 1 1 1\nNi 1.33", "illum 9\nd 0.9\nNi 1.33"}) {
    const Material material = OnlyMaterial(glass);
    EXPECT_EQ(material.bsdf, BsdfKind::kDielectric) << glass;
    EXPECT_FLOAT_EQ(material.ior, 1.33f) << glass;
  }
  EXPECT_FLOAT_EQ(OnlyMaterial("illum 6\nNi 1").ior, 1.5f);
  EXPECT_EQ(OnlyMaterial("Kd .5 .5 .5\nillum 4\nd 1").bsdf, BsdfKind::kLambert);
  EXPECT_EQ(OnlyMaterial("Kd .5 .5 .5\nillum 2\nTf 1 1 1").bsdf, BsdfKind::kLambert);
}

TEST(Mtl, PhysicallyBasedStatementsAreLayers) {
  const Material metal = OnlyMaterial("Kd .9 .6 .3\nPm .75\nPr .5\nKs 1 1 1\nNi 1.4");
  EXPECT_EQ(metal.bsdf, BsdfKind::kMetallicRoughness);
  ExpectNear(metal.reflectance, {0.9f, 0.6f, 0.3f});
  EXPECT_FLOAT_EQ(metal.metallic, 0.75f);
  EXPECT_FLOAT_EQ(metal.alpha, 0.25f);
  EXPECT_FLOAT_EQ(metal.ior, 1.4f);
  EXPECT_NEAR(OnlyMaterial("Pm 0\nNs 98").alpha, std::sqrt(2.0 / 100), 1e-6);
  EXPECT_FLOAT_EQ(OnlyMaterial("Pm 0").alpha, 0.25f);
  const Material coated = OnlyMaterial("Pr 1\nPc .5\nPcr .2\nPs .25");
  EXPECT_EQ(coated.bsdf, BsdfKind::kCoatedMetallicRoughness);
  EXPECT_FLOAT_EQ(coated.coat, 0.5f);
  EXPECT_FLOAT_EQ(coated.coat_alpha, 0.04f);
  ExpectNear(coated.sheen, {0.25f, 0.25f, 0.25f});
  Warnings remarks;
  Materials("newmtl a\nPr 1\nKs .5 .5 .5\n", remarks);
  EXPECT_EQ(WarningLines(remarks), std::vector<std::string>{});
  EXPECT_EQ(NoteLines(remarks),
            std::vector<std::string>{"t.mtl:3: Ks has no effect beside Pr and Pm"});
  EXPECT_EQ(MtlWarnings("newmtl a\nPr 1\naniso .5\n"),
            std::vector<std::string>{"t.mtl:3: aniso is not rendered: highlights are round"});
}

// map_Pr is in the green and map_Pm in the blue of one image, in the place of Pr and Pm; one file
// for both has them there itself.
TEST(Mtl, MapsOfRoughnessAndMetalAreRead) {
  const TemporaryFolder folder;
  WritePng(folder.Write("rough.png", ""), 2, 1, {51, 51, 51, 204, 204, 204});
  WritePng(folder.Write("metal.png", ""), 1, 1, {102, 102, 102});
  WritePng(folder.Write("packed.png", ""), 1, 1, {255, 51, 204});
  const auto texel = [&](const std::string& statements, int x) {
    Scene scene;
    Warnings warnings;
    TextureFiles textures{&scene};
    const Material material =
        ReadMtl(folder.Write("t.mtl", "newmtl m\n" + statements), textures, warnings).at(0);
    EXPECT_EQ(material.alpha, 1);
    EXPECT_EQ(material.metallic, 1);
    EXPECT_EQ(WarningLines(warnings), std::vector<std::string>{});
    const Texture& texture = scene.textures.at(material.roughness_texture.value());
    const auto rgb = scene.images.at(texture.image).Pixel(x, 0);
    return glm::vec3(rgb[0], rgb[1], rgb[2]);
  };
  ExpectNear(texel("Pm .5\nPr .7\nmap_Pr rough.png\nmap_Pm metal.png\n", 0), {0, 0.2f, 0.4f});
  ExpectNear(texel("map_Pr rough.png\nmap_Pm metal.png\n", 1), {0, 0.8f, 0.4f});
  ExpectNear(texel("Pm .5\nmap_Pr rough.png\n", 1), {0, 0.8f, 0.5f});
  ExpectNear(texel("Pr .5\nmap_Pm metal.png\n", 0), {0, 0.5f, 0.4f});
  ExpectNear(texel("map_Pr packed.png\nmap_Pm packed.png\n", 0), {0, 0.2f, 0.8f});
}

TEST(Mtl, UnsupportedStatementsAreReportedOnce) {
  EXPECT_EQ(MtlWarnings("newmtl a\nKd 1 1 1\nmap_Ks a.jpg\nnewmtl b\nKd 1 1 1\nmap_Ks b.jpg\n"
                        "Ke 0 0 0\n"),
            std::vector<std::string>{
                "t.mtl:3: map_Ks: textures are not supported: the plain value is used (2 times)"});
  EXPECT_EQ(MtlWarnings("newmtl a\nKd 1 1 1\nmap_Kd none.jpg\n"),
            std::vector<std::string>{
                "t.mtl:3: map_Kd: there is no file \"none.jpg\": the plain value is used"});
  EXPECT_EQ(MtlWarnings("newmtl a\nKd 1 1 1\n\nmap_Ke none.jpg\n"),
            std::vector<std::string>{
                "t.mtl:4: map_Ke: there is no file \"none.jpg\": the plain value is used"});
  EXPECT_EQ(MtlWarnings("newmtl a\nKd 1 1 2\n"),
            std::vector<std::string>{"t.mtl:2: Kd is clamped to [0, 1]"});
  EXPECT_EQ(MtlWarnings("newmtl a\nKd 1 1 1\nd .8\n").size(), 0u);
  EXPECT_EQ(MtlWarnings("newmtl a\nmap_d none.png\nbump no.png\n"),
            (std::vector<std::string>{
                "t.mtl:2: map_d: there is no file \"none.png\": the plain value is used",
                "t.mtl:3: bump: there is no file \"no.png\": the plain value is used"}));
  EXPECT_EQ(MtlWarnings("newmtl\nKd 1 1 1\n"),
            std::vector<std::string>{"t.mtl:1: 'newmtl' without a name: nothing can use it"});
  EXPECT_EQ(MtlWarnings("newmtl a\nKd 1 1 1\nKs .5 .5 .5\n").size(), 1u);
  EXPECT_EQ(MtlWarnings("newmtl a\nKd 1 1 1\nfrob 3\n"),
            std::vector<std::string>{"t.mtl:3: 'frob' is not a statement of MTL: ignored"});
}

// Models are copied into one folder and still name the folders of their makers.
TEST(Obj, FilesOfOtherFoldersAreFoundBesideTheOneThatNamesThem) {
  const TemporaryFolder folder;
  folder.Write("red one.mtl", "newmtl red\nKd 1 0 0\n");
  folder.Write("green one.mtl", "newmtl green\nKd 0 1 0\nmap_d C:\\models\\no.png\n");
  Image blue(1, 1);
  blue.rgb = {0, 0, 1};
  WriteExr(folder.Path("blue.exr"), blue);
  folder.Write("c.mtl", "newmtl blue\nmap_Kd C:\\models\\blue.exr\n");
  const Scene scene = ReadScene(folder.Write(
      "m.obj", std::string(kSquare) + "vt 0 0\nmtllib red one.mtl green one.mtl /models/c.mtl\n"
                                      "usemtl red\nf 1 2 3\nusemtl green\nf 1 3 4\n"
                                      "usemtl blue\nf 1/1 2/1 4/1\n"));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("\"C:\\models\\no.png\""), std::string::npos);
  std::string notes;
  for (const std::string& note : scene.notes) notes += note;
  EXPECT_NE(notes.find("no file \"/models/c.mtl\""), std::string::npos) << notes;
  EXPECT_NE(notes.find("no file \"C:/models/blue.exr\""), std::string::npos) << notes;
  ASSERT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.images.size(), 1u);
}

TEST(Obj, LibrariesOfOneStatementAndOfWindows) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.Path("sub"));  // #include <filesystem>
  folder.Write("a.mtl", "newmtl red\nKd 1 0 0\n");
  folder.Write("sub/b.mtl", "newmtl green\nKd 0 1 0\n");
  folder.Write("sub/c d.mtl", "newmtl blue\nKd 0 0 1\n");
  const Scene scene = ReadScene(
      folder.Write("m.obj", std::string(kSquare) + "mtllib a.mtl sub\\b.mtl\nmtllib sub\\c d.mtl\n"
                                                   "usemtl red\nf 1 2 3\nusemtl green\nf 1 3 4\n"
                                                   "usemtl blue\nf 1 2 4\n"));
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  ASSERT_EQ(scene.meshes.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    glm::vec3 color(0);
    color[i] = 1;
    ExpectNear(scene.materials[scene.meshes[std::size_t(i)].material].reflectance, color);
  }
}

}  // namespace
}  // namespace skywave
