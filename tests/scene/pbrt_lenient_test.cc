// What pbrt renders with a message, the reader takes with a warning, and refuses if it is strict.
#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "scene/pbrt/reader.h"

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

}  // namespace
}  // namespace skywave
