// What pbrt renders with a message, the reader takes with a warning, and refuses if it is strict.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "scene/pbrt/reader.h"
#include "scene/shapes/ply.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// Reads a scene that has one warning, which says `what` and its place, and which strict readers
// refuse.
Scene Warned(const std::string& text, const std::string& place, const std::string& what) {
  const Scene scene = ParsePbrt(text, "t.pbrt", {});
  EXPECT_EQ(scene.warnings.size(), 1u);
  for (const std::string& warning : scene.warnings) {
    EXPECT_NE(warning.find(what), warning.npos) << warning;
    EXPECT_NE(warning.find(place), warning.npos) << warning;
  }
  EXPECT_THROW(ParsePbrt(text, "t.pbrt", {.strict = true}), InputError);
  return scene;
}

TEST(PbrtLenient, TheLastOfTwoParametersOfANameCounts) {
  const Scene scene = Warned(
      "WorldBegin\nMaterial \"matte\" \"rgb Kd\" [.1 .2 .3] \"rgb Kd\" [.4 .5 .6]\n"
      "Shape \"sphere\"",
      "t.pbrt:2", "\"rgb Kd\" is given twice: the last one counts");
  EXPECT_EQ(scene.materials[scene.meshes.at(0).material].reflectance, glm::vec3(0.4f, 0.5f, 0.6f));
}

TEST(PbrtLenient, AnUnknownMaterialLeavesTheOneBeforeIt) {
  const Scene scene = Warned(
      "WorldBegin Material \"matte\" \"rgb Kd\" [.1 .2 .3]\nNamedMaterial \"a\"\n"
      "Shape \"sphere\"",
      "t.pbrt:2", "there is no material \"a\"");
  EXPECT_EQ(scene.materials[scene.meshes.at(0).material].reflectance, glm::vec3(0.1f, 0.2f, 0.3f));
}

TEST(PbrtLenient, AnUnknownTextureLeavesTheDefault) {
  const Scene scene =
      Warned("WorldBegin\nMaterial \"matte\" \"texture Kd\" \"t\"\nShape \"sphere\"", "t.pbrt:2",
             "names no texture that is there (\"t\"): the default is used");
  EXPECT_EQ(scene.materials[scene.meshes.at(0).material].reflectance, glm::vec3(0.5f));
}

// Instances between both definitions show the first one, as in pbrt-v3.
TEST(PbrtLenient, ASecondObjectOfANameIsThatOfLaterInstances) {
  const std::string object = "ObjectBegin \"a\" Shape \"sphere\" \"float radius\" ";
  const Scene scene = ParsePbrt("WorldBegin " + object + "1 ObjectEnd ObjectInstance \"a\"\n" +
                                    object + "3 ObjectEnd ObjectInstance \"a\"",
                                "t.pbrt", {.instances = InstanceUse::kCopy});
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("a second object \"a\""), std::string::npos);
  ASSERT_EQ(scene.meshes.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(glm::length(scene.meshes[i].positions.at(0)), i == 0 ? 1 : 3, 1e-5);
  }
}

// Version 3 multiplies what it writes by the film's scale; version 4 does not know it.
TEST(PbrtLenient, TheScaleOfAFilmOfVersion3IsThatOfAllLight) {
  const std::string film = "Film \"image\" \"float scale\" 2.5\n";
  const std::string lamp = "WorldBegin LightSource \"point\" \"rgb I\" [1 2 3]";
  const Scene v3 = ParsePbrt(film + lamp + "\nWorldEnd", "t.pbrt", {.strict = true});
  EXPECT_EQ(v3.lights.at(0).emission, glm::vec3(2.5f, 5, 7.5f));
  const Scene v4 = Warned(film + lamp, "t.pbrt:1", "\"float scale\" is not understood");
  EXPECT_EQ(v4.lights.at(0).emission, glm::vec3(1, 2, 3));
}

constexpr const char* kSphere = "Shape \"sphere\"\n";

// Version 3 has one stack for attributes and objects: AttributeEnd restores the state before the
// object, which goes on, and ObjectEnd that of the beginning.
TEST(PbrtLenient, AttributesAndObjectsOfVersion3MayEndCrosswise) {
  const std::string ball = "Shape \"sphere\" \"float radius\" ";
  const Scene scene = ParsePbrt(
      "WorldBegin AttributeBegin Translate 5 0 0 ObjectBegin \"o\" Translate 5 0 0 " + ball +
          "1\nAttributeEnd " + ball + "2\nObjectEnd " + ball + "3 ObjectInstance \"o\" WorldEnd",
      "t.pbrt", {.instances = InstanceUse::kCopy});
  ASSERT_EQ(scene.warnings.size(), 2u);
  EXPECT_NE(scene.warnings[0].find("t.pbrt:2: AttributeEnd closes the ObjectBegin of t.pbrt:1"),
            std::string::npos)
      << scene.warnings[0];
  EXPECT_NE(scene.warnings[1].find("t.pbrt:3: ObjectEnd closes the AttributeBegin of t.pbrt:1"),
            std::string::npos)
      << scene.warnings[1];
  ASSERT_EQ(scene.meshes.size(), 3u);
  const double middles[] = {0, 10, 5}, radii[] = {3, 1, 2};
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::dvec3 middle(middles[i], 0, 0);
    EXPECT_NEAR(glm::length(glm::dvec3(scene.meshes[i].positions.at(0)) - middle), radii[i], 1e-5)
        << i;
  }
}

TEST(PbrtLenient, EndsWithoutABeginningHaveNoEffectInVersion3) {
  for (const std::string end : {"AttributeEnd", "TransformEnd", "ObjectEnd"}) {
    const Scene scene = Warned("WorldBegin Translate 1 0 0\n" + end + " " + kSphere + "WorldEnd",
                               "t.pbrt:2", end + " without ");
    const glm::dvec3 point = scene.meshes.at(0).positions.at(0);
    EXPECT_NEAR(glm::length(point - glm::dvec3(1, 0, 0)), 1, 1e-5) << end;
  }
  Warned("WorldBegin\nAttributeBegin " + std::string(kSphere) + "WorldEnd", "t.pbrt:2",
         "AttributeBegin is never closed");
}

// Nothing is placed there, or what is placed is left out; the rest is rendered.
TEST(PbrtLenient, SingularTransformsRefuseNothingButWhatTheyPlace) {
  const std::string flat = "WorldBegin AttributeBegin\nScale 1 0 1\n";
  for (const std::string version : {"", "WorldEnd"}) {
    const Scene unused =
        ParsePbrt(flat + "AttributeEnd " + kSphere + version, "t.pbrt", {.strict = true});
    EXPECT_EQ(unused.meshes.size(), 1u);
    const Scene again = ParsePbrt(flat + "Identity " + kSphere + "AttributeEnd " + version,
                                  "t.pbrt", {.strict = true});
    EXPECT_EQ(again.meshes.size(), 1u);
    for (const std::string thing :
         {"Shape \"sphere\"", "LightSource \"point\"", "LightSource \"infinite\""}) {
      const Scene scene =
          Warned(flat + thing + " AttributeEnd\n" + kSphere + version, "t.pbrt:3",
                 thing + " under a transform that is singular since the Scale of t.pbrt:2");
      EXPECT_EQ(scene.meshes.size(), 1u) << thing;
      EXPECT_TRUE(scene.lights.empty()) << thing;
    }
  }
}

// The inverse of a matrix is rounded, which does not make it projective.
TEST(PbrtLenient, SpacesOfScaledCamerasPlaceShapes) {
  const Scene scene =
      ParsePbrt("Scale 9 9 9 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\" " +
                    std::string(kSphere),
                "t.pbrt", {.strict = true});
  EXPECT_NEAR(glm::length(scene.meshes.at(0).positions.at(0)), 1 / 9.0, 1e-6);
}

// A space is set for both ends of the exposure, as in pbrt.
TEST(PbrtLenient, ActiveTransformsDoNotKeepCoordinateSystemsOut) {
  const Scene scene = ParsePbrt(
      "WorldBegin Translate 5 0 0 CoordinateSystem \"a\" Identity ActiveTransform EndTime "
      "Translate 7 0 0 CoordSysTransform \"a\" ActiveTransform All " +
          std::string(kSphere),
      "t.pbrt", {});
  const glm::dvec3 point = scene.meshes.at(0).positions.at(0);
  EXPECT_NEAR(glm::length(point - glm::dvec3(5, 0, 0)), 1, 1e-5);
}

TEST(PbrtLenient, SolidTexturesUnderSingularTransformsAreThoseOfTheWorld) {
  Warned(
      "WorldBegin AttributeBegin\nScale 1 0 1\nTexture \"c\" \"spectrum\" \"marble\" "
      "AttributeEnd Material \"matte\" \"texture Kd\" \"c\" " +
          std::string(kSphere),
      "t.pbrt:3", "its transform is singular since the Scale of t.pbrt:2");
}

// The fourth row moves places, and an infinite light has none: it is turned about y.
TEST(PbrtLenient, ProjectiveTransformsTurnInfiniteLights) {
  const std::string quarter = "WorldBegin AttributeBegin ";
  const std::string matrices[] = {"Transform [0 0 -1 0  0 1 0 0  1 0 0 0  0 0 0 1]",
                                  "Transform [0 0 -1 .5  0 1 0 .25  1 0 0 0  0 0 0 1]"};
  const std::string light = " LightSource \"infinite\" AttributeEnd\n";
  const Scene plain = ParsePbrt(quarter + matrices[0] + light + kSphere, "t.pbrt", {});
  const Scene scene =
      ParsePbrt(quarter + matrices[1] + light + kSphere, "t.pbrt", {.strict = true});
  ASSERT_EQ(scene.environments.size(), 1u);
  EXPECT_EQ(scene.environments[0].world_from_map, plain.environments.at(0).world_from_map);
  Warned(quarter + matrices[1] + "\n" + kSphere + "AttributeEnd " + kSphere, "t.pbrt:2",
         "under a transform that is projective");
}

// The vertex without a normal gets that of its faces, and the others keep theirs.
TEST(PbrtLenient, ANormalThatIsNoNumberIsThatOfTheFaces) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
      "float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0 0 .6 .8\n1 0 0 0 1 nan\n"
      "0 1 0 0 0 1\n3 0 1 2\n";
  PlyReport report;
  const Mesh mesh = ParsePly(ply, "t.ply", &report);
  EXPECT_EQ(report.bad_normals, 1u);
  EXPECT_EQ(report.polygons, 1u);
  EXPECT_EQ(mesh.normals, (std::vector<glm::vec3>{{0, 0.6f, 0.8f}, {0, 0, 1}, {0, 0, 1}}));
  TemporaryFolder folder;
  WriteFileAtomically(folder.Path("t.ply"), ply);
  const std::string text = "WorldBegin\nShape \"plymesh\" \"string filename\" \"t.ply\"";
  const std::string path = folder.Path("t.pbrt");
  const Scene scene = ParsePbrt(text, path, {});
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("t.pbrt:2: normals that are not finite, 1 in number"),
            std::string::npos)
      << scene.warnings[0];
  EXPECT_THROW(ParsePbrt(text, path, {.strict = true}), InputError);
}

TEST(PbrtLenient, ACommaAfterANumberIsNotReadByVersion3) {
  const std::string text =
      "WorldBegin\nTranslate 1, 2, 3\nMaterial \"matte\" \"rgb Kd\" [.1, .2, .3]\n";
  const Scene scene = ParsePbrt(text + kSphere + "WorldEnd", "t.pbrt", {});
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0], "t.pbrt:2: a comma after a number: not read (4 times)");
  EXPECT_EQ(scene.materials[scene.meshes.at(0).material].reflectance, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_THROW(ParsePbrt(text + kSphere, "t.pbrt", {}), InputError);
  EXPECT_THROW(ParsePbrt("WorldBegin Translate 1,2 2 3 WorldEnd", "t.pbrt", {}), InputError);
}

}  // namespace
}  // namespace skywave
