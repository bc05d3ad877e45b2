// What pbrt-v3 and pbrt-v4 take differently, and round shapes that share their triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

#include "scene/pbrt/solid_textures.h"
#include "scene/pbrt/state.h"
#include "scene/reader.h"
#include "tests/support/expect_near.h"
#include "tests/support/pbrt_texts.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

double LuminanceOf(const glm::vec3& rgb) {
  return 0.2126 * double(rgb.x) + 0.7152 * double(rgb.y) + 0.0722 * double(rgb.z);
}

// pbrt-v4 divides a spectrum by its luminance; pbrt-v3 takes it as it is, and the constant 1 has
// the luminance 1.
TEST(PbrtVersions, SpectraOfLightsHaveLuminanceOneInVersion4) {
  const std::string sky =
      "WorldBegin\nLightSource \"infinite\" \"spectrum L\" [400 .001 700 .001]\n";
  EXPECT_NEAR(LuminanceOf(Parse(sky).environments.at(0).scale), 1, 2e-3);
  EXPECT_NEAR(LuminanceOf(Parse(sky + "WorldEnd").environments.at(0).scale), 0.001, 2e-6);
  const std::string point =
      "LightSource \"point\" \"spectrum I\" [400 3 550 0 700 8] \"float scale\" 5\n";
  EXPECT_NEAR(LuminanceOf(Parse(point).lights.at(0).emission), 5, 0.02);
  const Scene lamp =
      Parse("AreaLightSource \"diffuse\" \"spectrum L\" [400 7 700 7]\nShape \"sphere\"\n");
  EXPECT_NEAR(LuminanceOf(lamp.materials.back().emission), 1, 2e-3);
  EXPECT_EQ(
      Parse("LightSource \"infinite\" \"spectrum L\" [400 0 700 0]\n").environments.at(0).scale,
      glm::vec3(0));
  // Colours are radiance in both.
  EXPECT_EQ(Parse("LightSource \"infinite\" \"rgb L\" [3 3 3]\n").environments.at(0).scale,
            glm::vec3(3));
}

// The lamps of version 3 shine without a material, and let light pass.
TEST(PbrtVersions, LampsWithoutAMaterialShineInVersion3) {
  const std::string lamp =
      "WorldBegin\nMaterial \"none\"\nAreaLightSource \"diffuse\" \"rgb L\" [2 3 4]\nShape "
      "\"disk\"\n";
  const Scene shining = Parse(lamp + "WorldEnd");
  ASSERT_EQ(shining.meshes.size(), 1u);
  const Material& material = shining.materials.at(shining.meshes[0].material);
  EXPECT_EQ(material.emission, glm::vec3(2, 3, 4));
  EXPECT_EQ(material.bsdf, BsdfKind::kDielectric);
  EXPECT_EQ(material.ior, 1);
  EXPECT_EQ(material.reflectance, glm::vec3(1));
  EXPECT_TRUE(Parse(lamp).meshes.empty());
}

// Version 3 applies the transform of a texture to places, and version 4 its inverse.
TEST(PbrtVersions, PatternsInSpaceTakeTheTransformOfTheirVersion) {
  for (const bool v3 : {false, true}) {
    PbrtReader reader;
    reader.v3 = v3;
    reader.state.to_world = glm::scale(glm::dmat4(1), glm::dvec3(4));
    PbrtParameters parameters{InputPosition::File("t.pbrt"), "Texture", {}};
    const PbrtTexture checks = ReadSolidChecks(reader, parameters);
    const auto is_first = [&](double x) {
      return (*checks.solid)({.place = {x, 0.01, 0.01}, .normal = {}, .uv = {}}).x == 0;
    };
    // Cells of 1 / 4, or of 4.
    EXPECT_TRUE(is_first(0.1));
    EXPECT_EQ(is_first(0.3), !v3);
    EXPECT_EQ(is_first(0.6), true);
    EXPECT_EQ(is_first(4.1), v3);
  }
}

std::size_t Triangles(const std::vector<Mesh>& meshes) {
  std::size_t count = 0;
  for (const Mesh& mesh : meshes) count += mesh.triangles.size();
  return count;
}

TEST(PbrtRoundShapes, ShareTheirTriangles) {
  const TemporaryFolder folder;
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 300; ++i) {
    text += "AttributeBegin Translate " + std::to_string(3 * i) +
            " 0 0 Shape \"sphere\" \"float radius\" " + std::to_string(0.5 + 0.001 * i) +
            " AttributeEnd\n";
  }
  const Scene scene = ReadScene(folder.Write("many.pbrt", text));
  EXPECT_TRUE(scene.meshes.empty());
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(Triangles(scene.objects[0].meshes), 20480u);
  ASSERT_EQ(scene.instances.size(), 300u);
  const glm::dmat4x3& to = scene.instances[100].world_from_object;
  EXPECT_NEAR(to[0][0], 0.6, 1e-6);
  EXPECT_NEAR(to[3][0], 300, 1e-6);
}

// Few of them are meshes of their own, each with its form, material and orientation.
TEST(PbrtRoundShapes, AreWhatTheyWereAlone) {
  const std::string world =
      "WorldBegin\nShape \"sphere\"\nTranslate 5 0 0\nMaterial \"matte\" \"rgb Kd\" [1 0 0]\n"
      "Shape \"sphere\" \"float radius\" 2\nReverseOrientation\nShape \"sphere\" \"float radius\" "
      "2\n"
      "Shape \"cylinder\" \"float radius\" .5 \"float zmin\" 0 \"float zmax\" 3\n"
      "Shape \"disk\" \"float height\" 1 \"float radius\" .5\n"
      "Shape \"sphere\" \"float radius\" 2 \"float zmin\" 0\n";
  const Scene scene = Parse(world);
  ASSERT_EQ(scene.meshes.size(), 6u);
  EXPECT_TRUE(scene.warnings.empty());
  const auto volume = [](const Mesh& mesh) {
    double sum = 0;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 centre(5, 0, 0);
      const glm::dvec3 a = glm::dvec3(mesh.positions[t.x]) - centre,
                       b = glm::dvec3(mesh.positions[t.y]) - centre,
                       c = glm::dvec3(mesh.positions[t.z]) - centre;
      sum += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return sum;
  };
  constexpr double kSphere = 4.0 / 3 * 3.14159265358979;
  EXPECT_NEAR(volume(scene.meshes[0]), kSphere, 0.01);
  EXPECT_NEAR(volume(scene.meshes[1]), 8 * kSphere, 0.08);
  EXPECT_NEAR(volume(scene.meshes[2]), -8 * kSphere, 0.08);
  EXPECT_NE(scene.meshes[0].material, scene.meshes[1].material);
  EXPECT_EQ(scene.meshes[1].material, scene.meshes[2].material);
  float top = 0;
  for (const glm::vec3& p : scene.meshes[3].positions) top = std::max(top, p.z);
  EXPECT_FLOAT_EQ(top, 3);
  for (const glm::vec3& p : scene.meshes[5].positions) EXPECT_GE(p.z, -1e-6f);
}

}  // namespace
}  // namespace skywave
