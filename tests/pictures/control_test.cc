// Tests pictures with the control variate of irradiance: they have the expectation of those without
// it and less noise in the open, and everything that a film keeps of them adds up.
#include <gtest/gtest.h>

#include <vector>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/screens_scene.h"
#include "wavefront/policies/control_pilot.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// A sphere and a leaf over a ground under a sky with a sun.
Scene SphereOnGround(bool lamps) {
  Scene scene;
  const std::uint32_t matt = AddLambert(scene, "matt", {0.7f, 0.5f, 0.3f});
  scene.materials.push_back({.name = "leaf",
                             .bsdf = BsdfKind::kDiffuseTransmission,
                             .reflectance = {0.2f, 0.4f, 0.1f},
                             .second_color = {0.5f, 0.3f, 0.2f}});
  scene.materials.push_back({.name = "clay", .bsdf = BsdfKind::kOrenNayar, .alpha = 0.8f});
  Place(scene, Quad(6), matt, glm::vec3(0));
  Place(scene, Sphere(0.8f, 3), 2, {-0.6f, 0.8f, 0});
  Place(scene, Quad(0.7f), 1, {0.9f, 0.8f, 0.3f}, 30);
  scene.camera = LookAtCamera({0.3f, 2.4f, 4}, {0, 0.5f, 0}, {0, 1, 0}, 45, false);
  SetLight(scene, SkyWithSun(64, 32, 30, 0.2));
  if (lamps) scene.lights = {SlantingSpot(), SlantingSun()};
  return scene;
}

JobRequest Request(Integrator integrator, ControlVariate control, std::uint32_t split = 0) {
  JobRequest request = SmallRequest(48, 36, 16);
  request.integrator = integrator;
  request.strategy = "importance:compensate=1";
  request.options.of<ControlOptions>().control = control;
  request.options.bsdf_samples = split;
  return request;
}

Film Render(const RenderJob& job, FrameView frame) {
  Film film = job.MakeFilm();
  RenderFrame(frame, film);
  return film;
}

// Tests that the control changes nothing but the noise.
void ExpectSameWithControl(const Scene& scene, Integrator integrator, std::uint32_t split = 0) {
  constexpr int kRuns = 8;
  constexpr double kLevel = 1e-3;
  const RenderJob plain(scene, Request(integrator, ControlVariate::kNone, split));
  const RenderJob controlled(scene, Request(integrator, ControlVariate::kIrradiance, split));
  EXPECT_TRUE(SamePicture(MeanOfBlocks(EstimateFromEngine(controlled, kRuns, 100), 3),
                          MeanOfBlocks(EstimateFromEngine(plain, kRuns, 1000), 3), kLevel));
}

TEST(Control, KeepsDirectLight) {
  ExpectSameWithControl(SphereOnGround(false), Integrator::kDirect);
}
TEST(Control, KeepsPaths) { ExpectSameWithControl(SphereOnGround(false), Integrator::kPath); }
TEST(Control, KeepsLampsBesideTheMap) {
  ExpectSameWithControl(SphereOnGround(true), Integrator::kPath);
}
TEST(Control, KeepsPathsThatSplit) {
  ExpectSameWithControl(SphereOnGround(false), Integrator::kPath, 3);
}
TEST(Control, KeepsScreensAndNormalMaps) {
  ExpectSameWithControl(ScreensScene(), Integrator::kPath);
}
TEST(Control, KeepsEveryMaterial) {
  ExpectSameWithControl(BuiltinScene("materials"), Integrator::kPath);
}

// The light of an open ground under a sky is known analytically: no sample of it is noisy.
TEST(Control, LeavesNoNoiseOnOpenGround) {
  Scene scene;
  Place(scene, Quad(50), AddLambert(scene, "floor", {0.2f, 0.5f, 0.9f}), glm::vec3(0));
  scene.camera = LookAtCamera({0, 2, 0}, {0, 0, 0}, {0, 0, 1}, 40, false);
  SetLight(scene, SkyWithSun(64, 32, 400, 0.1));
  const RenderJob controlled(scene, Request(Integrator::kPath, ControlVariate::kIrradiance));
  const RenderJob plain(scene, Request(Integrator::kPath, ControlVariate::kNone));
  const auto noise = [](const RenderJob& job) {
    Film film = job.MakeFilm(*ParseAovs("variance"));
    RenderFrame(job.frame(), film);
    return film.Noise(16);
  };
  EXPECT_LT(noise(controlled), 1e-6);
  EXPECT_GT(noise(plain), 1e-2);
}

TEST(Control, HasTheSameBitsForAllThreadsAndWaves) {
  for (const Integrator integrator : {Integrator::kDirect, Integrator::kPath}) {
    const RenderJob job(SphereOnGround(true), Request(integrator, ControlVariate::kIrradiance));
    FrameView frame = job.frame();
    const Film first = Render(job, frame);
    frame.options.threads = 1, frame.options.wave = 1232;
    const Film second = Render(job, frame);
    EXPECT_TRUE(std::equal(first.sums().begin(), first.sums().end(), second.sums().begin()));
  }
}

TEST(Control, GroupsOfLightsAddUpToThePicture) {
  JobRequest request = Request(Integrator::kPath, ControlVariate::kIrradiance);
  request.options.aovs = *ParseAovs("lights,direct,indirect");
  const RenderJob job(SphereOnGround(true), request);
  const Film film = Render(job, job.frame());
  const auto groups = film.light_group_sums();
  const std::size_t values = film.sums().size();
  ASSERT_GT(groups.size(), values);
  for (std::size_t i = 0; i < values; ++i) {
    std::uint64_t sum = 0;
    for (std::size_t at = i; at < groups.size(); at += values) sum += groups[at];
    ASSERT_EQ(sum, film.sums()[i]) << "value " << i;
  }
  const std::vector<NamedChannel> layers = film.ResolveAovs(16);
  const Image picture = film.Resolve(16);
  const auto layer = [&](const std::string& name) -> const std::vector<float>& {
    return std::find_if(layers.begin(), layers.end(),
                        [&](const NamedChannel& channel) { return channel.name == name; })
        ->values;
  };
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
    EXPECT_NEAR(layer("direct.R")[i / 3] + layer("indirect.R")[i / 3], picture.rgb[i],
                1e-5f * (1 + std::abs(picture.rgb[i])));
  }
}

TEST(Control, PartsOfTheSamplesAddUpToTheWhole) {
  JobRequest request = Request(Integrator::kPath, ControlVariate::kIrradiance);
  request.options.aovs = *ParseAovs("variance,direct,lights");
  const RenderJob job(SphereOnGround(true), request);
  const Film whole = Render(job, job.frame());
  FrameView first = job.frame(), second = job.frame();
  first.options.samples_per_pixel = 5;
  second.options.samples_per_pixel = 11, second.options.first_sample = 5;
  Film parts = Render(job, first);
  parts.Merge(Render(job, second));
  EXPECT_EQ(parts.PackPicture(), whole.PackPicture());
  Film unpacked = job.MakeFilm();
  unpacked.UnpackPicture(whole.PackPicture());
  EXPECT_EQ(unpacked.Resolve(16).rgb, whole.Resolve(16).rgb);
}

TEST(Control, UnsupportedCombinationsAreRefused) {
  const auto refused = [](const JobRequest& request) {
    EXPECT_THROW(RenderJob(SphereOnGround(false), request), InputError) << request.strategy;
  };
  JobRequest request = Request(Integrator::kBdpt, ControlVariate::kIrradiance);
  refused(request);
  for (const char* strategy : {"median-cut", "bsdf", "ris", "hybrid"}) {
    request = Request(Integrator::kPath, ControlVariate::kIrradiance);
    request.strategy = strategy;
    refused(request);
  }
}

}  // namespace
}  // namespace skywave
