// Built-in scenes are complete and valid, and their sky conserves the sun's energy.
#include "scene/builtin/builtin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/gtc/constants.hpp>
#include <set>
#include <string>

#include "scene/builtin/procedural_sky.h"
#include "scene/builtin/scene_building.h"
#include "scene/reader.h"
#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

TEST(BuiltinScenes, AreCompleteAndSound) {
  for (const BuiltinSceneInfo& info : BuiltinScenes()) {
    SCOPED_TRACE(info.name);
    const Scene scene = ReadScene(std::string(info.name));
    EXPECT_FALSE(info.description.empty());
    EXPECT_TRUE(scene.camera);
    EXPECT_FALSE(scene.left_handed);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_TRUE(scene.settings.width && scene.settings.height && scene.settings.max_depth &&
                scene.settings.samples_per_pixel);
    // The lamps scene has local lights instead of an environment.
    ASSERT_EQ(scene.environments.size(), info.name == "lamps" ? 0u : 1u);
    EXPECT_EQ(scene.lights.size(), info.name == "lamps" ? 2u : 0u);
    std::size_t triangles = 0;
    for (const Mesh& mesh : scene.meshes) {
      SCOPED_TRACE(mesh.name);
      ASSERT_LT(mesh.material, scene.materials.size());
      ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
      EXPECT_EQ(FirstNonFinite(mesh.positions), mesh.positions.size());
      triangles += mesh.triangles.size();
      std::size_t against = 0;
      for (const glm::uvec3& t : mesh.triangles) {
        ASSERT_LT(std::max({t.x, t.y, t.z}), mesh.positions.size());
        const glm::vec3 normal = glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                            mesh.positions[t.z] - mesh.positions[t.x]);
        against +=
            !(glm::dot(normal, mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z]) > 0);
      }
      EXPECT_EQ(against, 0u);
    }
    if (info.name.starts_with("many-")) {
      EXPECT_NEAR(double(triangles), 1e6, 2e4);
    } else {
      EXPECT_LT(triangles, 300000u);
    }
  }
}

TEST(BuiltinScenes, FurnaceIsWhiteInConstantLight) {
  const Scene scene = BuiltinScene("furnace");
  EXPECT_EQ(scene.environments[0].scale, glm::vec3(1));
  EXPECT_FALSE(scene.environments[0].map);
  EXPECT_TRUE(scene.environments[0].map_path.empty());
  EXPECT_EQ(scene.materials.at(scene.meshes.at(0).material).reflectance, glm::vec3(1));
}

TEST(ProceduralSky, SunKeepsItsEnergyAndPlace) {
  for (const float azimuth : {-118.0f, 0.0f, 180.0f}) {
    for (const float elevation : {3.0f, 38.0f, 90.0f}) {
      ProceduralSky sky;
      sky.width = 256, sky.height = 128;
      sky.sun_azimuth_degrees = azimuth, sky.sun_elevation_degrees = elevation;
      // Only the sun emits; the rest is black.
      sky.zenith = sky.horizon = sky.ground = sky.glow = glm::vec3(0);
      const Image map = MakeProceduralSky(sky);
      const double pi = glm::pi<double>();
      double power = 0;
      glm::dvec3 towards(0);
      for (int y = 0; y < sky.height; ++y) {
        const double solid_angle =
            2 * pi / sky.width *
            (std::cos(y * pi / sky.height) - std::cos((y + 1) * pi / sky.height));
        for (int x = 0; x < sky.width; ++x) {
          const double theta = (y + 0.5) * pi / sky.height,
                       phi = 2 * pi * ((x + 0.5) / sky.width - 0.5);
          power += map.Pixel(x, y)[0] * solid_angle;
          towards += map.Pixel(x, y)[0] * solid_angle *
                     glm::dvec3(std::sin(theta) * std::sin(phi), std::cos(theta),
                                std::sin(theta) * std::cos(phi));
        }
      }
      EXPECT_NEAR(power / (sky.sun.x * 2 * pi * (1 - std::cos(pi / 180))), 1, 1e-5);
      const double e = glm::radians(double(elevation)), a = glm::radians(double(azimuth));
      const glm::dvec3 sun(std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a));
      EXPECT_GT(glm::dot(glm::normalize(towards), sun), std::cos(0.25 * pi / 180));
    }
  }
}

TEST(ProceduralSky, IsFinitePositiveAndTheSunIsBright) {
  const ProceduralSky sky;
  const Image map = MakeProceduralSky(sky);
  EXPECT_EQ(map.width, 1024);
  EXPECT_EQ(map.height, 512);
  float brightest = 0;
  for (const float v : map.rgb) {
    ASSERT_TRUE(std::isfinite(v) && v > 0);
    brightest = std::max(brightest, v);
  }
  // The reference is the zenith's luminance.
  const float ratio = brightest / Luminance(map.Pixel(512, 0));
  EXPECT_GT(ratio, 5e3f);
  EXPECT_LT(ratio, 5e4f);
}

// One of each, or a benchmark of "every BSDF" is none.
TEST(BuiltinScenes, ManyMaterialsHasEveryBsdf) {
  const Scene scene = BuiltinScene("many-materials");
  std::set<BsdfKind> expected, found;
  for (const Material& material : OneOfEachBsdf()) expected.insert(material.bsdf);
  for (std::size_t i = 1; i < scene.meshes.size(); ++i) {  // the first is the floor
    found.insert(scene.materials.at(scene.meshes[i].material).bsdf);
  }
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace skywave
