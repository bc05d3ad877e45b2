// Tests area lights of pbrt: their scope, power and images.
#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "scene/geometry.h"
#include "scene/local_lights.h"
#include "tests/support/made_image.h"
#include "tests/support/pbrt_lights.h"

namespace skywave {
namespace {

constexpr double kPi = 3.14159265358979323846;

TEST(PbrtLights, AreaLightsShineUntilTheirScopeEnds) {
  const Scene scene =
      Parse(std::string("Material \"matte\" \"rgb Kd\" [.1 .2 .3]\nAttributeBegin\n"
                        "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2 \"bool "
                        "twosided\" true\n") +
            kTriangle + kTriangle + "AttributeEnd\n" + kTriangle);
  EXPECT_TRUE(scene.warnings.empty());
  ASSERT_EQ(scene.meshes.size(), 3u);
  // Shapes of one light share a material.
  EXPECT_EQ(scene.meshes[0].material, scene.meshes[1].material);
  const Material& lit = scene.materials[scene.meshes[0].material];
  ExpectNear(lit.emission, {2, 4, 6});
  EXPECT_TRUE(lit.emits_on_both_sides);
  ExpectNear(lit.reflectance, {0.1f, 0.2f, 0.3f});
  const Material& dark = scene.materials[scene.meshes[2].material];
  EXPECT_EQ(dark.emission, glm::vec3(0));
  ExpectNear(dark.reflectance, {0.1f, 0.2f, 0.3f});
}

TEST(PbrtLights, AreaLightsTakeTheirMaterialFromTheirShape) {
  const Scene scene = Parse(std::string("AreaLightSource \"diffuse\"\nMaterial \"mirror\"\n") +
                            kTriangle + "Material \"matte\"\n" + kTriangle);
  EXPECT_EQ(scene.materials[scene.meshes.at(0).material].bsdf, BsdfKind::kMirror);
  EXPECT_EQ(scene.materials[scene.meshes.at(1).material].bsdf, BsdfKind::kLambert);
  for (const Mesh& mesh : scene.meshes) {
    ExpectNear(scene.materials[mesh.material].emission, glm::vec3(1));
  }
}

// Power is measured in the world: a scaled shape emits the same power.
TEST(PbrtLights, PowerIsThatOfEachShape) {
  for (const bool two_sided : {false, true}) {
    const Scene scene =
        Parse("AreaLightSource \"diffuse\" \"float power\" 30 \"bool twosided\" " +
              std::string(two_sided ? "true" : "false") + kTriangle + "Scale 3 3 3" + kTriangle);
    const Geometry geometry(scene, "t", 1);
    const LocalLights lights(scene, geometry, "t", 1, 0);
    EXPECT_EQ(lights.totals()[0].count, 2u);
    EXPECT_NEAR(lights.totals()[0].power, 60, 1e-3);
  }
}

// To pbrt every triangle, patch or polygon of a mesh is a lamp of that power.
TEST(PbrtLights, EveryFaceHasThePower) {
  const std::string quad =
      " Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] "
      "\"integer indices\" [0 1 2 0 2 3] ";
  const std::string patches =
      " Shape \"bilinearmesh\" \"point3 P\" [0 0 1 1 0 1 0 1 1 1 1 1 0 0 2 1 0 2] "
      "\"integer indices\" [0 1 2 3 0 1 4 5] ";
  const std::string ply = std::string(testing::TempDir()) + "quad_of_power.ply";
  std::ofstream(ply) << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                        "property float y\nproperty float z\nelement face 1\n"
                        "property list uchar int vertex_indices\nend_header\n"
                        "0 0 3\n1 0 3\n1 1 3\n0 1 3\n4 0 1 2 3\n";
  for (const auto& [shape, lamps] :
       {std::pair(quad, 2), std::pair(patches, 2),
        std::pair(" Shape \"plymesh\" \"string filename\" \"" + ply + "\"", 1)}) {
    SCOPED_TRACE(shape);
    const Scene scene = Parse("AreaLightSource \"diffuse\" \"float power\" 30 " + shape);
    const Geometry geometry(scene, "t", 1);
    const LocalLights lights(scene, geometry, "t", 1, 0);
    EXPECT_NEAR(lights.totals()[0].power, 30 * lamps, 1e-3);
  }
  std::filesystem::remove(ply);
}

// v points upwards on the image, and the power is that of the mean of the whole image.
TEST(PbrtLights, AreaLightsHaveImages) {
  const auto parse = [](const std::string& more) {
    const auto color = [](int, int y) { return glm::vec3(1 + 2 * y); };
    return ParseWithImage(
        MadeImage(1, 2, color),
        "AreaLightSource \"diffuse\" \"string filename\" \"image.pfm\" " + more + kTriangle);
  };
  const Scene scene = parse("\"float scale\" 2");
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.at(0);
  const Material& material = scene.materials[scene.meshes.at(0).material];
  ExpectNear(material.emission, glm::vec3(2));
  const Texture& texture = scene.textures[material.emission_texture.value()];
  EXPECT_EQ(texture.wrap_v, TextureWrap::kClamp);
  // v = 0 is the lower row of the image, the last one.
  EXPECT_EQ(texture.transform * glm::vec3(0.5f, 0, 1), glm::vec2(0.5f, 1));
  ASSERT_EQ(scene.meshes[0].uvs.size(), 3u);
  // The mean of the image is 2, and so is the area of the triangle.
  const Scene powerful = parse("\"float power\" 5");
  ExpectNear(powerful.materials[powerful.meshes.at(0).material].emission,
             glm::vec3(float(5 / (kPi * 2 * 2))));
  EXPECT_THROW(parse("\"rgb L\" [1 1 1]"), InputError);
}

}  // namespace
}  // namespace skywave
