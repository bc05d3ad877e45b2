// Tests surfaces of one side: the camera looks through their backs, and light does not.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/instances.h"
#include "scene/shapes/mesh.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "wavefront/option_names.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

Image Picture(const Scene& scene, Integrator integrator = Integrator::kPath,
              std::uint32_t depth = 2) {
  JobRequest request = SmallRequest(16, 16, 4);
  request.integrator = integrator;
  request.max_depth = depth;
  const RenderJob job(scene, request);
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  return film.Resolve(4);
}

testing::AssertionResult IsAll(const Image& image, const glm::vec3& color) {
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    if (image.rgb[i] != color[int(i % 3)]) {
      return testing::AssertionFailure() << "value " << i << " is " << image.rgb[i];
    }
  }
  return testing::AssertionSuccess();
}

Mesh Flipped(Mesh mesh) {
  FlipOrientation(mesh);
  return mesh;
}

// A camera looks straight down.
void LookDown(Scene& scene) {
  scene.camera = LookAtCamera({0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 60, false);
}

std::uint32_t AddOneSided(Scene& scene, const glm::vec3& reflectance,
                          const glm::vec3& emission = glm::vec3(0)) {
  const std::uint32_t material = AddLambert(scene, "one-sided", reflectance);
  scene.materials[material].emission = emission;
  scene.materials[material].one_sided = true;
  return material;
}

// Returns a black sheet under the camera and a constant environment of 1.
Scene Sheet(const Mesh& mesh) {
  Scene scene;
  Place(scene, mesh, AddOneSided(scene, glm::vec3(0)), glm::vec3(0));
  LookDown(scene);
  SetConstantLight(scene, 1);
  return scene;
}

TEST(OneSided, CameraLooksThroughBacksInEveryIntegrator) {
  for (const auto& [integrator, name] : kEnumNames<Integrator>) {
    SCOPED_TRACE(name);
    EXPECT_TRUE(IsAll(Picture(Sheet(Quad(9)), integrator), glm::vec3(0)));
    EXPECT_TRUE(IsAll(Picture(Sheet(Flipped(Quad(9))), integrator), glm::vec3(1)));
  }
}

TEST(OneSided, WindingDecidesWhichSideIsTheBack) {
  Mesh wound = Quad(9);  // the normals stay
  for (glm::uvec3& corners : wound.triangles) std::swap(corners.y, corners.z);
  EXPECT_TRUE(IsAll(Picture(Sheet(wound)), glm::vec3(1)));
  Mesh normals = Quad(9);
  for (glm::vec3& normal : normals.normals) normal = -normal;
  EXPECT_TRUE(IsAll(Picture(Sheet(normals)), glm::vec3(0)));
}

TEST(OneSided, MixturesHaveTheSidesOfTheirOwn) {
  for (const bool flipped : {false, true}) {
    Scene scene = Sheet(flipped ? Flipped(Quad(9)) : Quad(9));
    scene.materials.insert(scene.materials.begin(), 2, {.reflectance = glm::vec3(0)});
    scene.materials[2].mixture = Mixture{0, 1, 0.5f};
    scene.meshes[0].material = 2;
    EXPECT_TRUE(IsAll(Picture(scene), glm::vec3(flipped ? 1.0f : 0.0f)));
  }
}

// Neither of two sheets in one place is beyond the other.
TEST(OneSided, SheetsBackToBackShowOneSideEach) {
  for (const bool alpha : {false, true}) {
    Scene scene;
    const std::uint32_t red = AddOneSided(scene, glm::vec3(0), {1, 0, 0});
    const std::uint32_t blue = AddOneSided(scene, glm::vec3(0), {0, 0, 1});
    if (alpha) {
      for (Material& material : scene.materials) material.opacity_cutoff = 0.25f;
      for (Material& material : scene.materials) material.opacity = 0.5f;
    }
    Place(scene, Quad(9), red, glm::vec3(0));
    Place(scene, Flipped(Quad(9)), blue, glm::vec3(0));
    LookDown(scene);
    EXPECT_TRUE(IsAll(Picture(scene), {1, 0, 0})) << alpha;
    std::swap(scene.meshes[0].material, scene.meshes[1].material);
    EXPECT_TRUE(IsAll(Picture(scene), {0, 0, 1})) << alpha;
  }
}

TEST(OneSided, BacksOfMirroredInstancesAreThoseOfTheirCopies) {
  for (const double side : {1.0, -1.0}) {
    for (const InstanceUse use : {InstanceUse::kCopy, InstanceUse::kShare}) {
      Scene scene;
      const std::uint32_t black = AddOneSided(scene, glm::vec3(0));
      Mesh front = Quad(9);
      front.material = black;
      // A mesh of two sides in the world before it, so that numbers of triangles matter.
      Place(scene, Quad(0.1f), AddLambert(scene, "two-sided", glm::vec3(0)), {50, 0, 0});
      scene.objects = {{.name = "sheet", .meshes = {front}}};
      const glm::dmat4 mirrored = glm::scale(glm::dmat4(1), glm::dvec3(-1, side, 1));
      scene.instances = {{.object = 0, .world_from_object = glm::dmat4x3(mirrored)}};
      LookDown(scene);
      SetConstantLight(scene, 1);
      ReadOptions options;
      options.instances = use;
      ResolveInstances(options, "test", scene);
      ASSERT_EQ(scene.instances.size(), use == InstanceUse::kShare ? 1u : 0u);
      EXPECT_TRUE(IsAll(Picture(scene), glm::vec3(side > 0 ? 0.0f : 1.0f)))
          << side << ToString(use);
    }
  }
}

TEST(OneSided, BothSidesCastShadows) {
  for (const bool flipped : {false, true}) {
    Scene scene;
    Place(scene, Quad(9), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
    // The camera looks below the sheet; light falls from above it.
    Place(scene, flipped ? Flipped(Quad(4)) : Quad(4), AddOneSided(scene, glm::vec3(0)), {0, 3, 0});
    scene.lights = {
        {.kind = LocalLightKind::kDistant, .emission = {1, 1, 1}, .direction = glm::vec3(0, 1, 0)}};
    LookDown(scene);
    EXPECT_TRUE(IsAll(Picture(scene), glm::vec3(0))) << flipped;
    scene.meshes.pop_back();
    EXPECT_GT(Picture(scene).rgb[0], 0.1f);
  }
}

// Connections of light paths to the camera see what camera rays see.
TEST(OneSided, LightPathsMatchPathTracing) {
  Scene scene;
  Place(scene, Quad(4), AddLambert(scene, "floor", {0.5f, 0.55f, 0.6f}), glm::vec3(0));
  Place(scene, Sphere(0.7f, 20), AddLambert(scene, "ball", {0.8f, 0.3f, 0.2f}), {0, 0.7f, 0});
  // One sheet shows its back to the camera, one its front.
  Place(scene, Flipped(Quad(0.8f)), AddOneSided(scene, {0.2f, 0.9f, 0.4f}), {-0.4f, 1.6f, 1.5f});
  Place(scene, Quad(0.3f), AddOneSided(scene, {0.3f, 0.3f, 0.9f}), {0.9f, 1.1f, 1.2f});
  scene.camera = LookAtCamera({0.4f, 2.4f, 4.5f}, {0, 0.65f, 0}, {0, 1, 0}, 40, false);
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  const double level = SidakLevel(2);
  const auto estimate = [&](Integrator integrator, int salt) {
    JobRequest request = SmallRequest(32, 24, 48);
    request.max_depth = 4;
    request.integrator = integrator;
    return EstimateFromEngine(RenderJob(scene, request), 12, salt);
  };
  const PictureEstimate paths = estimate(Integrator::kPath, 900);
  EXPECT_TRUE(SamePicture(estimate(Integrator::kLight, 100), paths, level));
  EXPECT_TRUE(SamePicture(estimate(Integrator::kBdpt, 400), paths, level));
}

}  // namespace
}  // namespace skywave
