// Tests the weights that a pilot gives to the control variate, in whole frames.
#include "wavefront/policies/control_pilot.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// Walls without a roof, seen from above: no sky is in the picture, whose edges would be noise that
// light samples do not make.
Scene Court() {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "white", glm::vec3(0.7f));
  const auto wall = [&](const glm::vec3& centre, const glm::vec3& half) {
    Place(scene, Facetted(RoundedBox(half, 0.01f, 1)), white, centre);
  };
  wall({0, 0, 0}, {2, 0.05f, 2});
  wall({0, 1.5f, -2}, {2, 1.5f, 0.05f}), wall({0, 1.5f, 2}, {2, 1.5f, 0.05f});
  wall({-2, 1.5f, 0}, {0.05f, 1.5f, 2}), wall({2, 1.5f, 0}, {0.05f, 1.5f, 2});
  Place(scene, Sphere(0.3f), white, {-0.6f, 0.4f, -0.5f});
  scene.camera = LookAtCamera({0.5f, 6, 0.5f}, {0, 0, 0}, {0, 0, 1}, 30, false);
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  return scene;
}

JobRequest Request(ControlVariate control, Integrator integrator = Integrator::kPath) {
  JobRequest request = SmallRequest(32, 24, 16);
  request.integrator = integrator;
  request.max_depth = 3;
  request.options.of<ControlOptions>().control = control;
  return request;
}

// Returns the weights that a frame learns, and whether it still has a control.
std::pair<std::unique_ptr<ControlWeights>, bool> Learn(const RenderJob& job) {
  FrameView frame = job.frame();
  WorkerPool pool(frame.options);
  PilotCounts counts;
  std::unique_ptr<ControlWeights> weights = LearnControl(pool, frame, counts);
  EXPECT_EQ(pool.stats().samples, 0u);
  return {std::move(weights), frame.find<ControlView>() != nullptr};
}

double TotalVariance(const PictureEstimate& estimate) {
  return std::accumulate(estimate.variance.begin(), estimate.variance.end(), 0.0);
}

TEST(ControlPilot, WeightsFollowWhatIsHidden) {
  const auto [court, court_has] = Learn(RenderJob(Court(), Request(ControlVariate::kIrradiance)));
  EXPECT_TRUE(court_has);
  const auto [least, most] = std::minmax_element(court->of_places.begin(), court->of_places.end());
  EXPECT_GE(*least, 0);
  EXPECT_LT(*least, 0.9f);
  EXPECT_GT(*most, 0.3f);
  EXPECT_LE(*most, 1);
  // Through a small opening little is known of what arrives, so the control goes.
  EXPECT_FALSE(Learn(RenderJob(RoomUnderSkylight(), Request(ControlVariate::kIrradiance))).second);
}

TEST(ControlPilot, PicturesHaveTheExpectationOfThoseWithoutAndNoMoreNoise) {
  // With weight 1 everywhere the noise is 1.04 and 0.95 times that without the control.
  for (const auto& [integrator, noise] :
       {std::pair{Integrator::kDirect, 1.02}, std::pair{Integrator::kPath, 0.93}}) {
    const auto estimate = [&, integrator = integrator](ControlVariate control) {
      return EstimateFromEngine(RenderJob(Court(), Request(control, integrator)), 12, 70);
    };
    const PictureEstimate plain = estimate(ControlVariate::kNone);
    const PictureEstimate controlled = estimate(ControlVariate::kIrradiance);
    EXPECT_TRUE(SamePicture(plain, controlled, SidakLevel(2)));
    EXPECT_LT(TotalVariance(controlled), noise * TotalVariance(plain));
  }
}

TEST(ControlPilot, PicturesDependOnNeitherThreadsNorWavesNorParts) {
  const RenderJob job(Court(), Request(ControlVariate::kIrradiance));
  const auto render = [&](const FrameView& frame) {
    Film film = job.MakeFilm();
    RenderFrame(frame, film);
    return std::vector<std::uint64_t>(film.sums().begin(), film.sums().end());
  };
  const std::vector<std::uint64_t> reference = render(job.frame());
  FrameView frame = job.frame();
  frame.options.threads = 1;
  EXPECT_EQ(render(frame), reference);
  frame = job.frame();
  frame.options.wave = 40;
  EXPECT_EQ(render(frame), reference);
  std::vector<std::uint64_t> sums(reference.size());
  for (const std::uint32_t first : {0u, 7u}) {
    frame = job.frame();
    frame.options.picture_samples = {0, 16};
    frame.options.first_sample = first, frame.options.samples_per_pixel = first == 0 ? 7 : 9;
    const std::vector<std::uint64_t> part = render(frame);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += part[i];
  }
  EXPECT_EQ(sums, reference);
}

}  // namespace
}  // namespace skywave
