// Tests the pilot of the strategy `visibility` in whole frames.
#include <gtest/gtest.h>

#include "tests/support/picture_estimate.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "wavefront/guiding/visibility_pilot.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// A room with an opening in its roof under a sky with a sun, seen from inside.
Scene Room() {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "white", glm::vec3(0.7f));
  const auto wall = [&](const glm::vec3& centre, const glm::vec3& half) {
    Place(scene, Facetted(RoundedBox(half, 0.01f, 1)), white, centre);
  };
  wall({0, 0, 0}, {2, 0.05f, 2});
  wall({0, 1, -2}, {2, 1, 0.05f}), wall({0, 1, 2}, {2, 1, 0.05f});
  wall({-2, 1, 0}, {0.05f, 1, 2}), wall({2, 1, 0}, {0.05f, 1, 2});
  wall({-1.2f, 2, 0}, {0.8f, 0.05f, 2}), wall({1.2f, 2, 0}, {0.8f, 0.05f, 2});
  wall({0, 2, -1.2f}, {0.4f, 0.05f, 0.8f}), wall({0, 2, 1.2f}, {0.4f, 0.05f, 0.8f});
  Place(scene, Quad(0.2f), AddMirror(scene, 0.9f), {0.2f, 1.2f, 0});
  Place(scene, Sphere(0.3f), AddMetal(scene, "Cu", 0.3f), {-0.6f, 0.4f, -0.5f});
  scene.camera = LookAtCamera({1.2f, 1.2f, 1.5f}, {-0.3f, 0.5f, -0.4f}, {0, 1, 0}, 70, false);
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  return scene;
}

JobRequest Request(const std::string& strategy, std::uint32_t samples = 16) {
  JobRequest request = SmallRequest(32, 24, samples);
  request.integrator = Integrator::kPath;
  request.max_depth = 4;
  request.strategy = strategy;
  return request;
}

std::vector<std::uint64_t> Render(const RenderJob& job, const FrameView& frame) {
  Film film = job.MakeFilm();
  RenderFrame(frame, film);
  return {film.sums().begin(), film.sums().end()};
}

TEST(VisibilityPilot, PicturesDependOnNeitherThreadsNorWavesNorParts) {
  const RenderJob job(Room(), Request("visibility"));
  const std::vector<std::uint64_t> reference = Render(job, job.frame());
  for (const int threads : {1, 3}) {
    FrameView frame = job.frame();
    frame.options.threads = threads;
    EXPECT_EQ(Render(job, frame), reference) << threads;
  }
  for (const std::uint32_t wave : {24u, 2048u}) {
    FrameView frame = job.frame();
    frame.options.wave = wave;
    EXPECT_EQ(Render(job, frame), reference) << wave;
  }
  std::vector<std::uint64_t> sums(reference.size());
  for (const std::uint32_t first : {0u, 7u}) {
    FrameView frame = job.frame();
    frame.options.first_sample = first, frame.options.samples_per_pixel = first == 0 ? 7 : 9;
    const std::vector<std::uint64_t> part = Render(job, frame);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += part[i];
  }
  EXPECT_EQ(sums, reference);
}

TEST(VisibilityPilot, LeavesStatisticsToTheFrame) {
  const RenderJob job(Room(), Request("visibility", 2));
  Film film = job.MakeFilm();
  const FrameResult result = RenderFrame(job.frame(), film);
  EXPECT_GT(result.visibility.paths, 10000u);
  EXPECT_GT(result.visibility.samples, result.visibility.paths);
  EXPECT_EQ(result.stats.samples, 32u * 24 * 2);
  EXPECT_EQ(result.stats.rays[0], 32u * 24 * 2);
  const RenderJob plain(Room(), Request("importance", 2));
  Film other = plain.MakeFilm();
  EXPECT_EQ(RenderFrame(plain.frame(), other).visibility.paths, 0u);
}

PictureEstimate Estimate(JobRequest request) {
  return EstimateFromEngine(RenderJob(Room(), request), 12, 70);
}

TEST(VisibilityPilot, PicturesAreThoseOfOtherStrategies) {
  const PictureEstimate plain = Estimate(Request("importance"));
  EXPECT_TRUE(SamePicture(plain, Estimate(Request("visibility")), SidakLevel(3)));
  EXPECT_TRUE(SamePicture(plain, Estimate(Request("visibility:compensate=0")), SidakLevel(3)));
  // Continuations of split paths have a strategy of their own, which learns too.
  JobRequest split = Request("importance", 4);
  split.options.split = 4, split.continuation_strategy = "visibility";
  EXPECT_TRUE(SamePicture(plain, Estimate(split), SidakLevel(3)));
}

TEST(VisibilityPilot, DirectLightIsLessNoisy) {
  double variance[2] = {};
  for (const bool taught : {false, true}) {
    JobRequest request = Request(taught ? "visibility" : "importance:compensate=1", 4);
    request.integrator = Integrator::kDirect;
    for (const double of_channel : Estimate(request).variance) variance[taught] += of_channel;
  }
  EXPECT_LT(variance[1], 0.7 * variance[0]);
}

}  // namespace
}  // namespace skywave
