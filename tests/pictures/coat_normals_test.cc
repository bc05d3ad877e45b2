// Renders coats whose normals are not those of their base, in constant light, where what they
// reflect is known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "scene/shapes/mesh.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/screens_scene.h"
#include "tests/support/statistics.h"

namespace skywave {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// A square with a coat, seen from 60 degrees off its normal. Its maps tilt normals by so many
// degrees towards the eye; 0: there is no map.
Scene CoatedSquare(double coat_tilt, double base_tilt) {
  Scene scene;
  Material material = {.bsdf = BsdfKind::kLayeredMetallicRoughness,
                       .reflectance = glm::vec3(0),
                       .alpha = 1e-3f,
                       .coat = 1,
                       .coat_alpha = 1e-3f,
                       .specular = 0,
                       .own_base_normals = true};
  const auto map = [&](double degrees) -> std::optional<std::uint32_t> {
    if (degrees == 0) return std::nullopt;
    const double tilt = degrees * kDegree;
    scene.images.push_back(Plain(NormalColor({std::sin(tilt), 0, std::cos(tilt)})));
    scene.textures.push_back(
        {.image = std::uint32_t(scene.images.size() - 1), .use = TextureUse::kNormals});
    return std::uint32_t(scene.textures.size() - 1);
  };
  material.normal_texture = map(coat_tilt), material.base_normal_texture = map(base_tilt);
  scene.materials = {material};
  Place(scene, Quad(1), 0, glm::vec3(0));
  SetConstantLight(scene, 1);
  const double angle = 60 * kDegree;
  const glm::vec3 eye(50 * std::sin(angle), 50 * std::cos(angle), 0);
  scene.camera = LookAtCamera(eye, glm::vec3(0), {0, 1, 0}, 0.5f, false);
  return scene;
}

// What a smooth coat of index 1.5 reflects (Schlick 1994).
double Reflectance(double degrees) {
  return 0.04 + 0.96 * std::pow(1 - std::cos(degrees * kDegree), 5);
}

void ExpectRadiance(const Scene& scene, double expected, double tolerance) {
  for (const char* const strategy : {"importance", "cosine"}) {
    JobRequest request = SmallRequest(8, 8, 256);
    request.strategy = strategy;
    const PictureEstimate mean =
        MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), 6, 3), 8);
    const double error = std::sqrt(mean.variance[0]);
    EXPECT_NEAR(mean.mean[0], expected, tolerance + 5 * error) << strategy;
    EXPECT_LT(error, 0.02);
  }
}

TEST(CoatNormals, ACoatOverBlackReflectsByItsOwnNormals) {
  ExpectRadiance(CoatedSquare(0, 0), Reflectance(60), 1e-3);
  ExpectRadiance(CoatedSquare(-10, 0), Reflectance(70), 1e-3);
  ExpectRadiance(CoatedSquare(20, -10), Reflectance(40), 1e-3);
  ExpectRadiance(CoatedSquare(0, -10), Reflectance(60), 1e-3);
}

// A mirror below a coat. What it sends back leaves through the coat at another angle: the larger of
// both reflectances is missing.
TEST(CoatNormals, ABaseReflectsByItsOwnNormals) {
  for (const double tilt : {-10.0, 10.0}) {
    Scene scene = CoatedSquare(0, tilt);
    scene.materials[0].reflectance = glm::vec3(1), scene.materials[0].metallic = 1;
    const double lost = std::max(Reflectance(60), Reflectance(60 - 2 * tilt));
    ExpectRadiance(scene, Reflectance(60) + 1 - lost, 0.01);
  }
}

// Flux that meets base and coat is what radiance the other way is.
TEST(CoatNormals, PathsFromLightsMakeTheSamePicture) {
  Scene scene = CoatedSquare(0, -25);
  scene.camera = LookAtCamera({4, 2.5f, 0}, glm::vec3(0), {0, 1, 0}, 30, false);
  Material& material = scene.materials[0];
  material.reflectance = {0.9f, 0.6f, 0.3f}, material.metallic = 0.5f, material.alpha = 0.4f;
  material.coat_alpha = 0.3f, material.specular = 1;
  Place(scene, Sphere(0.3f, 4), AddLambert(scene, "ball", glm::vec3(0.7f)), {0.2f, 0.4f, 0});
  for (const Integrator integrator : {Integrator::kLight, Integrator::kBdpt, Integrator::kVcm}) {
    SCOPED_TRACE(int(integrator));
    JobRequest request = SmallRequest(12, 12, 256);
    request.integrator = integrator;
    EXPECT_TRUE(SameAsPaths(scene, request, 6, SidakLevel(3)));
  }
}

}  // namespace
}  // namespace skywave
