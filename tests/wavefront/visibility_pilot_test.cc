// Tests the pilot of the strategy `visibility` in whole frames.
#include <gtest/gtest.h>

#include "tests/support/picture_estimate.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "wavefront/integrators/path.h"
#include "wavefront/policies/visibility_pilot.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

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
  const RenderJob job(RoomUnderSkylight(), Request("visibility"));
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
  const RenderJob job(RoomUnderSkylight(), Request("visibility", 2));
  Film film = job.MakeFilm();
  const FrameResult result = RenderFrame(job.frame(), film);
  EXPECT_GT(result.pilots.of("visibility").paths, 10000u);
  EXPECT_GT(result.pilots.of("visibility").samples, result.pilots.of("visibility").paths);
  EXPECT_EQ(result.stats.samples, 32u * 24 * 2);
  EXPECT_EQ(result.stats.rays[0], 32u * 24 * 2);
  const RenderJob plain(RoomUnderSkylight(), Request("importance", 2));
  Film other = plain.MakeFilm();
  EXPECT_EQ(RenderFrame(plain.frame(), other).pilots.of("visibility").paths, 0u);
}

PictureEstimate Estimate(JobRequest request) {
  return EstimateFromEngine(RenderJob(RoomUnderSkylight(), request), 12, 70);
}

TEST(VisibilityPilot, PicturesMatchOtherStrategies) {
  const PictureEstimate plain = Estimate(Request("importance"));
  EXPECT_TRUE(SamePicture(plain, Estimate(Request("visibility")), SidakLevel(3)));
  EXPECT_TRUE(SamePicture(plain, Estimate(Request("visibility:compensate=0")), SidakLevel(3)));
  // Continuations of split paths have a strategy of their own, which learns too.
  JobRequest split = Request("importance", 4);
  split.options.bsdf_samples = 4, split.continuation_strategy = "visibility";
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
