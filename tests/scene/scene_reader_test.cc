// Tests pbrt scenes: every directive, the syntax of both versions, and the warnings about
// unsupported features. Numbers are computed by hand from pbrt's conventions.
#include "scene/materials/spectrum.h"
#include "scene/pbrt/reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "base/error.h"
#include "scene/reader.h"
#include "scene/scene.h"
#include "tests/support/expect_near.h"
#include "tests/support/pbrt_texts.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// Returns the position to which `directives` move the point (1, 2, 3).
glm::vec3 Transformed(const std::string& directives) {
  const Scene scene = Parse(
      "WorldBegin\n" + directives +
      "\nShape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [1 2 3 5 5 5 5 0 0]");
  return scene.meshes.at(0).positions.at(0);
}

glm::vec3 GeometricNormal(const Mesh& mesh, std::size_t i = 0) {
  const glm::uvec3 t = mesh.triangles[i];
  return glm::normalize(glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                   mesh.positions[t.z] - mesh.positions[t.x]));
}

TEST(Transforms, MatchHandComputedMatrices) {
  ExpectNear(Transformed(""), {1, 2, 3});
  ExpectNear(Transformed("Translate 10 20 30"), {11, 22, 33});
  ExpectNear(Transformed("Translate [10 20 30]"), {11, 22, 33});
  ExpectNear(Transformed("Scale 2 3 -1"), {2, 6, -3});
  ExpectNear(Transformed("Rotate 90 0 0 1"), {-2, 1, 3});
  ExpectNear(Transformed("Rotate 90 0 2 0"), {3, 2, -1});
  // The last directive acts first.
  ExpectNear(Transformed("Translate 10 0 0 Scale 2 2 2"), {12, 4, 6});
  ExpectNear(Transformed("Scale 2 2 2 Translate 10 0 0"), {22, 4, 6});
  ExpectNear(Transformed("Translate 9 9 9 Identity"), {1, 2, 3});
  // The columns map x to y, y to z, z to x; a translation follows.
  const std::string matrix = "[0 1 0 0  0 0 1 0  1 0 0 0  7 8 9 1]";
  ExpectNear(Transformed("Translate 1 1 1 Transform " + matrix), {10, 9, 11});
  ExpectNear(Transformed("Translate 1 1 1 ConcatTransform " + matrix), {11, 10, 12});
  // A viewer at (0, 0, -5) that looks along +z with y up sees x on the right.
  ExpectNear(Transformed("LookAt 0 0 -5  0 0 0  0 1 0"), {1, 2, 8});
  // Looking along +x with y up, the right is -z in a left-handed world.
  ExpectNear(Transformed("LookAt 0 0 0  1 0 0  0 1 0"), {-3, 2, 1});
}

TEST(Transforms, CoordinateSystemsAreRecalled) {
  ExpectNear(Transformed("Translate 1 0 0 CoordinateSystem \"a\" Scale 5 5 5 Identity "
                         "CoordSysTransform \"a\""),
             {2, 2, 3});
  const Scene scene = Parse(std::string("Translate 0 0 4 Camera \"perspective\" WorldBegin\n"
                                        "CoordSysTransform \"camera\"\n") +
                            kTriangle);
  ExpectNear(scene.meshes.at(0).positions[0], {0, 0, -4});
}

TEST(Transforms, MotionIsReadAtItsStart) {
  ExpectNear(Transformed("ActiveTransform EndTime Translate 9 9 9 Scale 2 2 2 Identity "
                         "ActiveTransform StartTime Translate 1 0 0 ActiveTransform All "
                         "Translate 0 0 1"),
             {2, 2, 4});
  ExpectNear(Transformed("TransformBegin ActiveTransform EndTime TransformEnd Translate 1 0 0"),
             {2, 2, 3});
}

TEST(Transforms, WorldBeginResetsTheTransform) {
  const Scene scene = Parse(std::string("Translate 1 2 3 WorldBegin\n") + kTriangle);
  ExpectNear(scene.meshes.at(0).positions[0], {0, 0, 0});
}

TEST(Transforms, NormalsKeepTheirSide) {
  const std::string mesh =
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0] "
      "\"normal N\" [0 0 1 0 0 1 0 0 1]\n";
  for (const char* transform : {"", "Scale -1 1 1", "Rotate 70 1 2 3", "Scale 1 2 -3",
                                "ReverseOrientation", "ReverseOrientation Scale -1 1 1"}) {
    const Mesh smooth = Parse(std::string("WorldBegin ") + transform + "\n" + mesh).meshes.at(0);
    const Mesh flat = Parse(std::string("WorldBegin ") + transform + "\n" + kTriangle).meshes.at(0);
    ExpectNear(GeometricNormal(smooth), smooth.normals[0]);
    // Flat or smooth, the outside is the same.
    ExpectNear(GeometricNormal(flat), smooth.normals[0]);
    EXPECT_NEAR(glm::length(smooth.normals[1]), 1, 1e-6);
  }
  // A mirror keeps the normal (0, 0, 1); ReverseOrientation flips it.
  ExpectNear(Parse("WorldBegin Scale -1 1 1\n" + mesh).meshes.at(0).normals[0], {0, 0, 1});
  ExpectNear(Parse("WorldBegin ReverseOrientation\n" + mesh).meshes.at(0).normals[0], {0, 0, -1});
  const Mesh twice =
      Parse("WorldBegin ReverseOrientation ReverseOrientation\n" + mesh).meshes.at(0);
  ExpectNear(twice.normals[0], {0, 0, 1});
  // Where pbrt turns round shapes and subdivisions inside out, they are; lamps are not.
  const auto faces_out = [](const std::string& text) {
    const Mesh inside_out = Parse("WorldBegin " + text).meshes.at(0);
    const glm::vec3 middle = inside_out.positions[inside_out.triangles[0].x];
    const bool out = glm::dot(GeometricNormal(inside_out), middle) > 0;
    EXPECT_EQ(glm::dot(inside_out.normals[inside_out.triangles[0].x], middle) > 0, out);
    return out;
  };
  EXPECT_TRUE(faces_out("Shape \"sphere\""));
  EXPECT_FALSE(faces_out("Scale -1 1 1 Shape \"sphere\""));
  EXPECT_TRUE(faces_out("Scale -1 1 1 ReverseOrientation Shape \"sphere\""));
  EXPECT_TRUE(faces_out("AreaLightSource \"diffuse\" Scale -1 1 1 Shape \"sphere\""));
  const std::string solid =
      "Shape \"loopsubdiv\" \"integer levels\" 2 \"point3 P\" [1 1 1 -1 -1 1 -1 1 -1 1 -1 -1] "
      "\"integer indices\" ";
  EXPECT_FALSE(faces_out(solid + "[0 2 1 0 1 3 0 3 2 1 2 3]"));
  EXPECT_TRUE(faces_out(solid + "[0 1 2 0 3 1 0 2 3 1 3 2]"));
  // Normals take precedence over the winding.
  const Mesh against = Parse(
                           "WorldBegin Shape \"trianglemesh\" \"integer indices\" [0 1 2] "
                           "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 -1 0 0 -1 0 0 -1]")
                           .meshes.at(0);
  ExpectNear(GeometricNormal(against), {0, 0, -1});
}

TEST(Scopes, RestoreWhatTheySave) {
  const std::string v4 = std::string(
                             "WorldBegin\nMaterial \"mirror\"\nAttributeBegin\n"
                             "Material \"glass\" Translate 5 0 0 ReverseOrientation\n"
                             "AttributeEnd\n") +
                         kTriangle + "TransformBegin Translate 7 0 0 Material \"matte\"\n" +
                         kTriangle + "TransformEnd\n" + kTriangle;
  const Scene scene = Parse(v4 + "WorldEnd\n");
  ASSERT_EQ(scene.meshes.size(), 3u);
  const auto kind = [&](int i) { return scene.materials[scene.meshes[i].material].bsdf; };
  EXPECT_EQ(kind(0), BsdfKind::kMirror);
  ExpectNear(scene.meshes[0].positions[0], {0, 0, 0});
  ExpectNear(GeometricNormal(scene.meshes[0]), {0, 0, 1});
  ExpectNear(scene.meshes[1].positions[0], {7, 0, 0});
  // TransformEnd restores the transform only, but in version 4, which has no WorldEnd, all.
  EXPECT_EQ(kind(2), BsdfKind::kLambert);
  ExpectNear(scene.meshes[2].positions[0], {0, 0, 0});
  const Scene newer = Parse(v4);
  EXPECT_EQ(newer.materials[newer.meshes.at(2).material].bsdf, BsdfKind::kMirror);
  ExpectNear(newer.meshes[2].positions[0], {0, 0, 0});
  // Each may close what the other has opened, in version 4 only.
  const std::string crossed =
      "WorldBegin AttributeBegin TransformEnd TransformBegin AttributeEnd AttributeBegin "
      "AttributeEnd ";
  EXPECT_NO_THROW(Parse(crossed));
  EXPECT_THROW(Parse(crossed + "WorldEnd"), InputError);
  EXPECT_THROW(Parse("WorldBegin ObjectBegin \"o\" AttributeEnd"), InputError);
  EXPECT_THROW(Parse("WorldBegin ObjectBegin \"o\" TransformEnd WorldEnd"), InputError);
}

TEST(Scopes, AttributesReachWhatFollows) {
  const Scene scene = Parse(
      "WorldBegin\nAttribute \"shape\" \"float radius\" 2\nAttribute \"material\" \"float eta\" "
      "1.7\nAttributeBegin\nAttribute \"shape\" \"float radius\" 3\nShape \"sphere\"\n"
      "Shape \"sphere\" \"float radius\" 4\nAttributeEnd\nMaterial \"glass\" Shape \"sphere\"\n");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const float radii[] = {3, 4, 2};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(glm::length(scene.meshes.at(i).positions[0]), radii[i], 1e-5) << i;
  }
  EXPECT_FLOAT_EQ(scene.materials.at(scene.meshes[2].material).ior, 1.7f);
}

TEST(Objects, InstancesAreTransformedCopies) {
  const Scene scene =
      Parse(std::string("WorldBegin\nObjectBegin \"o\"\nTranslate 1 0 0\n") + kTriangle +
            "ObjectEnd\nAttributeBegin Scale 2 2 2 ObjectInstance \"o\" AttributeEnd\n"
            "Translate 0 0 3 Scale -1 1 1 ObjectInstance \"o\"");
  ASSERT_EQ(scene.meshes.size(), 2u);
  ExpectNear(scene.meshes[0].positions[0], {2, 0, 0});
  ExpectNear(scene.meshes[0].positions[1], {4, 0, 0});
  ExpectNear(scene.meshes[1].positions[0], {-1, 0, 3});
  ExpectNear(GeometricNormal(scene.meshes[1]), {0, 0, 1});
}

TEST(Objects, InstancesShareTheirTriangles) {
  const std::string text =
      std::string("WorldBegin\nObjectBegin \"o\"\nTranslate 1 0 0\n") + kTriangle +
      "ObjectEnd\nAttributeBegin Scale 2 3 4 ObjectInstance \"o\" AttributeEnd\n" + kTriangle +
      "Translate 0 0 3 ObjectInstance \"o\"";
  ReadOptions options;
  options.instances = InstanceUse::kShare;
  const Scene scene = ParsePbrt(text, "t.pbrt", options);
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].name, "o");
  ASSERT_EQ(scene.objects[0].meshes.size(), 1u);
  ExpectNear(scene.objects[0].meshes[0].positions[0], {1, 0, 0});
  ASSERT_EQ(scene.instances.size(), 2u);
  ExpectNear(scene.instances[0].world_from_object * glm::dvec4(1, 1, 1, 1), {2, 3, 4});
  ExpectNear(scene.instances[1].world_from_object * glm::dvec4(1, 1, 1, 1), {1, 1, 4});
  EXPECT_EQ(scene.meshes.size(), 1u);
  options.max_instances = 1;
  try {
    ParsePbrt(text, "t.pbrt", options);
    ADD_FAILURE() << "two instances are read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("more than 1 instances"), std::string::npos);
  }
}

TEST(Shapes, SpheresMeshesAndSubdivisionAreRead) {
  const Scene scene = Parse(
      "WorldBegin Translate 1 0 0 Shape \"sphere\" \"float radius\" 2\n"
      "Identity Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"float uv\" [0 0 1 0 0 1]\n"
      "Shape \"loopsubdiv\" \"integer nlevels\" 1 \"integer indices\" [0 1 2] \"point P\" "
      "[0 0 0 1 0 0 0 1 0]\n"
      "Shape \"loopsubdiv\" \"integer levels\" 2 \"integer indices\" [0 1 2] \"point3 P\" "
      "[0 0 0 1 0 0 0 1 0]\n"
      "Shape \"loopsubdiv\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0]\n");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  for (const glm::vec3& p : scene.meshes.at(0).positions) {
    EXPECT_NEAR(glm::distance(p, glm::vec3(1, 0, 0)), 2, 1e-5);
  }
  EXPECT_EQ(scene.meshes.at(1).triangles.at(0), glm::uvec3(0, 1, 2));
  EXPECT_EQ(scene.meshes.at(1).uvs.at(1), glm::vec2(1, 0));
  EXPECT_EQ(scene.meshes.at(2).triangles.size(), 4u);
  EXPECT_EQ(scene.meshes.at(3).triangles.size(), 16u);
  EXPECT_EQ(scene.meshes.at(4).triangles.size(), 64u);  // three levels are pbrt's default
}

TEST(Lights, InfiniteLightsHaveTheirFrames) {
  const Scene constant =
      Parse("WorldBegin LightSource \"infinite\" \"rgb L\" [1 2 3] \"float scale\" 2");
  ASSERT_EQ(constant.environments.size(), 1u);
  EXPECT_TRUE(constant.environments[0].map_path.empty());
  ExpectNear(constant.environments[0].scale, {2, 4, 6});
  ExpectNear(constant.environments[0].world_from_map[0], {0, -1, 0});  // right
  ExpectNear(constant.environments[0].world_from_map[1], {-1, 0, 0});  // forward
  ExpectNear(constant.environments[0].world_from_map[2], {0, 0, 1});   // up
  // This is the common rotation of an upright map in a y-up world: light +z to world +y.
  const glm::mat3 upright =
      Parse("WorldBegin Rotate -90 1 0 0 LightSource \"infinite\" \"color scale\" [2 2 2]")
          .environments.at(0)
          .world_from_map;
  ExpectNear(upright[2], {0, 1, 0});
  ExpectNear(upright[1], {-1, 0, 0});
  ExpectNear(upright[0], {0, 0, 1});
  // Uniform scales change no direction; mirrors do.
  const glm::mat3 mirrored =
      Parse("WorldBegin Scale -3 3 3 LightSource \"infinite\"").environments.at(0).world_from_map;
  ExpectNear(mirrored[1], {1, 0, 0});
  ExpectNear(mirrored[0], {0, -1, 0});
}

TEST(Files, IncludesAndMapsAreLookedUpInTheFolderOfTheirFile) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.Path("parts"));
  folder.Write("parts/shape.pbrt", kTriangle);
  folder.Write("parts/map.hdr", "");
  folder.Write("parts/light.pbrt",
               "LightSource \"infinite\" \"string mapname\" \"map.hdr\"\n"
               "LightSource \"infinite\" \"string filename\" \"parts/map.hdr\"\n");
  folder.Write("parts/all.pbrt", "Include \"shape.pbrt\"\nImport \"light.pbrt\"\n");
  const std::string path = folder.Write("main.pbrt", "WorldBegin\nInclude \"parts/all.pbrt\"\n");
  const Scene scene = ReadScene(path);
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.environments.size(), 2u);
  EXPECT_TRUE(std::filesystem::exists(scene.environments[0].map_path));
  // as in pbrt: relative to the main file
  EXPECT_TRUE(std::filesystem::exists(scene.environments[1].map_path));
}

// Parameters may go on in the file that includes the one with their directive, as in the cloud of
// pbrt-v3's scenes.
// As in pbrt-v3; --missing refuse and --strict do not.
TEST(Files, APartThatIsMissingLeavesTheRest) {
  const TemporaryFolder folder;
  const std::string path = folder.Write(
      "main.pbrt", "WorldBegin\nInclude \"none.pbrt\"\nShape \"sphere\"\nInclude \"two.pbrt\"\n");
  const Scene scene = ReadScene(path);
  EXPECT_EQ(scene.meshes.size() + scene.instances.size(), 1u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("main.pbrt:2: Include: there are no files \"none.pbrt\", "
                                   "\"two.pbrt\": left out"),
            std::string::npos)
      << scene.warnings[0];
  EXPECT_THROW(ReadScene(path, {.strict = true}), InputError);
  EXPECT_THROW(ReadScene(path, {.missing = MissingFiles::kRefuse}), InputError);
}

TEST(Files, ParametersGoOnAfterAnInclude) {
  const TemporaryFolder folder;
  folder.Write("ball.pbrt", "Translate 1 0 0 Shape \"sphere\"  # and nothing after it\n");
  folder.Write("outer.pbrt", "Include \"ball.pbrt\"\n");
  const auto radius_of = [&](const std::string& include) {
    const Scene scene = ReadScene(folder.Write(
        "main.pbrt", "WorldBegin\n" + include + " \"float radius\" 3\nShape \"sphere\"\n"));
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.meshes.size() + scene.instances.size(), 2u);
    const Bounds bounds = TriangleBounds(scene);
    return (bounds.high.x - bounds.low.x) / 2;
  };
  EXPECT_NEAR(radius_of("Include \"ball.pbrt\""), 3, 0.01);
  EXPECT_NEAR(radius_of("Include \"outer.pbrt\""), 3, 0.01);
  EXPECT_THROW(radius_of("Import \"ball.pbrt\""), InputError);
}

// What an imported file sets ends with it, and what it inherits does not.
TEST(Files, ImportsKeepTheirStateToThemselves) {
  const TemporaryFolder folder;
  const std::string part = std::string("Translate 5 0 0\n") + kTriangle +
                           "Material \"mirror\" ReverseOrientation\n"
                           "Attribute \"shape\" \"float radius\" 3\n";
  folder.Write("part.pbrt", part);
  const std::string rest = std::string(kTriangle) + "Shape \"sphere\"\n";
  const std::string begin = "WorldBegin\nTranslate 0 1 0 Material \"glass\"\n";
  const auto read = [&](const std::string& directive) {
    return ReadScene(folder.Write("main.pbrt", begin + directive + " \"part.pbrt\"\n" + rest));
  };
  const Scene imported = read("Import"), included = read("Include");
  ASSERT_EQ(imported.meshes.size(), 3u);
  ExpectNear(imported.meshes[0].positions[0], {5, 1, 0});
  EXPECT_EQ(imported.materials[imported.meshes[0].material].bsdf, BsdfKind::kDielectric);
  ExpectNear(imported.meshes[1].positions[0], {0, 1, 0});
  ExpectNear(GeometricNormal(imported.meshes[1]), {0, 0, 1});
  EXPECT_EQ(imported.materials[imported.meshes[1].material].bsdf, BsdfKind::kDielectric);
  EXPECT_NEAR(glm::length(imported.meshes[2].positions[0] - glm::vec3(0, 1, 0)), 1, 1e-5);
  ExpectNear(included.meshes.at(1).positions[0], {5, 1, 0});
  EXPECT_EQ(included.materials[included.meshes[1].material].bsdf, BsdfKind::kMirror);
}

TEST(Files, PlyAloneAndInAScene) {
  const TemporaryFolder folder;
  const std::string ply = folder.Write("t.PLY",
                                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                                       "property float y\nproperty float z\nelement face 1\n"
                                       "property list uchar int vertex_indices\nend_header\n"
                                       "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Scene alone = ReadScene(ply);
  EXPECT_FALSE(alone.left_handed);
  ASSERT_EQ(alone.materials.size(), 1u);
  EXPECT_EQ(alone.materials[0].bsdf, BsdfKind::kLambert);
  const Scene scene = ReadScene(folder.Write(
      "m.pbrt", "WorldBegin Translate 1 1 1 Shape \"plymesh\" \"string filename\" \"t.PLY\""));
  ExpectNear(scene.meshes.at(0).positions.at(1), {2, 1, 1});
}

TEST(Syntax, CommentsBracketsAndNumbers) {
  const Scene scene = Parse(
      "# a comment [\"\n"
      "WorldBegin # another\n"
      "Translate +1 -.5 2e0#glued\n"
      "Shape\"trianglemesh\"\"integer indices\"[0 1 2]\"point3 P\"[0 0 0 1 0 0 0 1 0]\n"
      "Shape \"trianglemesh\" \"integer  indices\" [ 0.0 1 2 ] \"\tpoint3\tP \" [0 0 0 1 0 0 0 1 "
      "1e-60]");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  ASSERT_EQ(scene.meshes.size(), 2u);
  ExpectNear(scene.meshes[0].positions[0], {1, -0.5f, 2});
}

TEST(Warnings, SayWhereAndWhatIsDone) {
  const Scene scene = Parse(
      "Film \"rgb\" \"string filename\" \"out.exr\"\n"              // 1
      "WorldBegin\n"                                                // 2
      "LightSource \"laser\" \"rgb I\" [1 1 1]\n"                   // 3
      "Material \"velvet\" \"float pile\" 2\n"                      // 4
      "Shape \"nurbs\"\n"                                           // 5
      "Shape \"sphere\"\n"                                          // 6
      "  \"float bulge\" 2\n"                                       // 7
      "Shape \"nurbs\"\n"                                           // 8
      "Material \"dielectric\" \"float roughness\" 0.1\n"           // 9
      "Texture \"wood\" \"spectrum\" \"ptex\" \"float gamma\" 1\n"  // 10
      "Material \"matte\" \"texture Kd\" \"wood\"\n"                // 11
      "AreaLightSource \"laser\" \"rgb L\" [1 1 1]\n"               // 12
      "WorldEnd\n"                                                  // 13
      "WorldBegin\n");                                              // 14
  const std::vector<std::string> expected = {
      "t.pbrt:3: LightSource \"laser\" is not supported: left out",
      "t.pbrt:4: Material \"velvet\" is not supported: rendered as grey Lambert",
      "t.pbrt:5: Shape \"nurbs\" is not supported: left out (2 times)",
      "t.pbrt:7: Shape \"sphere\": \"float bulge\" is not understood: ignored",
      "t.pbrt:10: Texture \"wood\" \"ptex\" is not supported: its users take their default",
      "t.pbrt:12: AreaLightSource \"laser\" is not supported: left out",
      "t.pbrt:14: everything after WorldEnd is ignored",
  };
  EXPECT_EQ(scene.warnings, expected);
  // What makes no difference to the picture is apart.
  EXPECT_EQ(scene.notes, std::vector<std::string>{
                             "t.pbrt:1: Film \"rgb\": \"filename\" is ignored: the output is "
                             "named on the command line"});
}

// A space lasts as its scope does. Reflectances are adapted to daylight, and lights are not.
TEST(ColorSpaces, AreThoseOfTheirScope) {
  const std::string paint = " Material \"matte\" \"rgb Kd\" [.5 .4 .3] Shape \"sphere\" ";
  const Scene scene =
      Parse("WorldBegin AttributeBegin ColorSpace \"rec2020\"" + paint + "AttributeEnd" + paint +
            "ColorSpace \"aces2065-1\" LightSource \"infinite\" \"rgb L\" [1 1 1]");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  const auto color = [&](std::size_t mesh) {
    return scene.materials[scene.meshes.at(mesh).material].reflectance;
  };
  const glm::vec3 wide(0.5f * 1.6605f - 0.4f * 0.5876f - 0.3f * 0.0728f,
                       -0.5f * 0.1246f + 0.4f * 1.1329f - 0.3f * 0.0083f,
                       -0.5f * 0.0182f - 0.4f * 0.1006f + 0.3f * 1.1187f);
  const glm::vec3 white = scene.environments.at(0).scale;
  const glm::vec3 d60 = RgbOfIlluminant("illum-acesD60").value();
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(color(0)[c], wide[c], 5e-4f) << c;
    EXPECT_EQ(color(1)[c], (glm::vec3(.5f, .4f, .3f))[c]) << c;
    EXPECT_NEAR(white[c], d60[c], 2e-3f) << c;
  }
  EXPECT_THROW(Parse("WorldBegin ColorSpace \"rec709\""), InputError);
}

// Each of these must give at least one line that begins with its position.
TEST(Warnings, EverythingSkippedIsReported) {
  for (const char* text : {"Camera \"realistic\"",
                           "Camera \"perspective\" \"float shutterspeed\" 1",
                           "Sampler \"sobol\"",
                           "Integrator \"mlt\"",
                           "Integrator \"path\" \"bool regularize\" true",
                           "PixelFilter \"mitchell\" \"float B\" 1",
                           "PixelFilter \"gaussian\" \"float sigma\" 2",
                           "Accelerator \"bvh\"",
                           "Film \"gbuffer\" \"float diagonal\" 35",
                           "Option \"forcediffuse\" true",
                           "ColorSpace \"rec2020\" Material \"matte\" \"rgb Kd\" [0 1 0]",
                           "ActiveTransform StartTime",
                           "TransformTimes 0 1",
                           "MakeNamedMedium \"m\" \"string type\" \"homogeneous\"",
                           "MediumInterface \"m\" \"\"",
                           "Attribute \"medium\" \"float scale\" 2",
                           "Attribute \"shape\" \"float bulge\" 2 Shape \"sphere\"",
                           "LightSource \"laser\"",
                           "LightSource \"point\" \"float bulge\" 1",
                           "Film \"rgb\" \"string sensor\" \"canon_eos_100d\"",
                           "LightSource \"infinite\" \"spectrum L\" \"stdillum-X\"",
                           "Scale 1 2 1 LightSource \"infinite\"",
                           "Material \"uber\" \"rgb opacity\" [.3 .4 .5]",
                           "Material \"coatedconductor\" \"float interface.vroughness\" .4",
                           "Material \"coateddiffuse\" \"float uroughness\" .4",
                           "Material \"plastic\" \"float uroughness\" .4",
                           "Material \"conductor\" \"spectrum eta\" \"metal-Xx-eta\"",
                           "Material \"matte\" \"rgb Kd\" [2 0 0]",
                           "Shape \"nurbs\"",
                           "Shape \"sphere\" \"integer radius\" 2",
                           "Material \"none\" Shape \"sphere\"",
                           "AreaLightSource \"goniometric\""}) {
    const Scene scene = Parse(std::string("\n") + text);
    ASSERT_FALSE(scene.warnings.empty() && scene.notes.empty()) << text;
    for (const auto* remarks : {&scene.warnings, &scene.notes}) {
      for (const std::string& remark : *remarks) {
        EXPECT_TRUE(remark.starts_with("t.pbrt:2: ")) << text << " -> " << remark;
      }
    }
  }
}

TEST(Warnings, SupportedFilesCauseNoWarnings) {
  EXPECT_EQ(
      Parse(
          "LookAt 0 0 0 0 0 1 0 1 0 Camera \"perspective\" \"float fov\" 40\n"
          "Film \"image\" \"integer xresolution\" 64 \"integer yresolution\" 64\n"
          "Integrator \"path\" \"integer maxdepth\" 5 ColorSpace \"srgb\"\n"
          "PixelFilter \"box\" \"float xradius\" .5 \"float yradius\" .5\nWorldBegin\n"
          "LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
          "Material \"metal\" \"float roughness\" .1 \"bool remaproughness\" \"true\"\n"
          "Shape \"sphere\" \"float radius\" 1 \"float zmin\" -1 \"float phimax\" 360\nWorldEnd\n")
          .warnings,
      std::vector<std::string>{});
}

}  // namespace
}  // namespace skywave
