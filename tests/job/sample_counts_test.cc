// Tests the map of where light samples of a render fall.
#include "job/sample_counts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "lights/light_sets/light_builder.h"
#include "lights/maps/sphere_map.h"
#include "lights/tables/max_pyramid.h"
#include "tests/support/made_image.h"
#include "tests/support/render_scenes.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr int kWidth = 32, kHeight = 16, kLitX = 9, kLitY = 3;

// Returns a floor under a map that is dark but for one texel.
Scene Floor() {
  Scene scene;
  Place(scene, Quad(2), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  scene.camera = LookAtCamera({0, 3, 2}, {0, 0, 0}, {0, 1, 0}, 40, false);
  Image map(kWidth, kHeight);
  std::fill_n(map.Pixel(kLitX, kLitY), 3, 8.0f);
  SetLight(scene, std::move(map));
  return scene;
}

JobRequest Request(const std::string& strategy) {
  JobRequest request = SmallRequest(16, 12, 8);
  request.strategy = strategy;
  request.integrator = Integrator::kDirect;
  return request;
}

TEST(SampleCounts, AreThoseOfTheShadowRays) {
  for (const float rotation : {0.0f, 77.0f}) {
    JobRequest request = Request("importance:compensate=0");
    request.environment.rotation_degrees = rotation;
    const RenderJob job(Floor(), request);
    Film film = job.MakeFilm();
    const FrameResult result = RenderFrame(job.frame(), film);
    const Image counts = CountSamples(job);
    ASSERT_EQ(counts.width, kWidth);
    double all = 0;
    for (std::size_t i = 0; i < counts.rgb.size(); i += 3) all += double(counts.rgb[i]);
    EXPECT_EQ(all, double(result.stats.rays[std::size_t(RayKind::kShadow)]));
    // Wherever the map is turned to.
    EXPECT_GT(counts.Pixel(kLitX, kLitY)[0], 0.99 * all);
    EXPECT_GT(all, 1000);
  }
}

// Uniform directions that rise above the floor are everywhere on the upper half, by solid angle.
TEST(SampleCounts, OfUniformDirectionsGoWithTheSolidAngle) {
  JobRequest request = Request("uniform");
  request.samples_per_pixel = 256;
  Scene scene = Floor();
  SetConstantLight(scene, 1);
  const Image counts = CountSamples(RenderJob(scene, request));
  const auto of_row = [&](int y) {
    double sum = 0;
    for (int x = 0; x < counts.width; ++x) sum += double(counts.Pixel(x, y)[0]);
    return sum;
  };
  EXPECT_NEAR(of_row(1) / of_row(6), std::sin(1.5 * M_PI / 16) / std::sin(6.5 * M_PI / 16), 0.03);
  EXPECT_EQ(of_row(counts.height - 1), 0);
}

// Samples that merge are taken out of the set, and what they make is put in.
TEST(MergedSamples, MakeTheLightsOfTheSet) {
  const Image image = SkyWithSun(256, 128, 3, 0.4);
  const SphereMap map = MakeSphereMap(image);
  LightOptions options = {.source = LightSource::kPenrose,
                          .lights = 120,
                          .position = LightPosition::kSample,
                          .cluster = ClusterFrequency::kOne,
                          .stop = {.clusters = 80}};
  const MergedSamples samples = MergeSamples(map, options);
  const std::size_t after = samples.kept.size() + samples.made.size();
  EXPECT_EQ(after, 80u);
  EXPECT_GT(samples.kept.size(), 0u);
  EXPECT_GE(samples.merged.size(), 2 * samples.made.size());
  EXPECT_EQ(BuildLights(map, options).lights.size(), after);
  options.stop.clusters = 0;
  options.cluster.reset();
  EXPECT_EQ(BuildLights(map, options).lights.size(), samples.kept.size() + samples.merged.size());
}

// On a plane, all rows of a white map weigh the same; on the sphere those at the poles less.
TEST(PlanePyramid, WeighsEachTexelByItsLuminanceAlone) {
  Image white(8, 4);
  std::fill(white.rgb.begin(), white.rgb.end(), 1.0f);
  const SphereMap map = MakeSphereMap(white);
  const MaxPyramid plane = PlanePyramid(map), sphere = ImportancePyramid(map);
  EXPECT_EQ(plane.levels[0].value[0], plane.levels[0].value[2 * 8]);
  EXPECT_LT(sphere.levels[0].value[0], 0.5f * sphere.levels[0].value[2 * 8]);
}

}  // namespace
}  // namespace skywave
