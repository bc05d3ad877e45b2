// Tests the pilot that chooses for the strategy `auto`, in whole frames.
#include "wavefront/policies/strategy_pilot.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/render_scenes.h"
#include "wavefront/integrators/path.h"
#include "wavefront/records/irradiance_cache.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

JobRequest Request(const std::string& strategy) {
  JobRequest request = SmallRequest(64, 48, 4);
  request.integrator = Integrator::kPath;
  request.max_depth = 4;
  request.strategy = strategy;
  return request;
}

struct Rendered {
  std::vector<std::uint64_t> sums;
  FrameResult result;
};

Rendered Render(const RenderJob& job, const FrameView& frame) {
  Film film = job.MakeFilm();
  Rendered rendered;
  rendered.result = RenderFrame(frame, film);
  rendered.sums.assign(film.sums().begin(), film.sums().end());
  return rendered;
}

Rendered RenderOpen(const std::string& strategy) {
  JobRequest request = Request(strategy);
  request.scene = "furnace";
  const RenderJob job(request);
  return Render(job, job.frame());
}

Rendered RenderInside(const JobRequest& request) {
  const RenderJob job(RoomUnderSkylight(), request);
  return Render(job, job.frame());
}

double Product(const CandidateScore& score) { return score.variance * score.cost; }

// Expects one choice, which is that of the least product, and returns it.
std::string Chosen(const FrameResult& result) {
  if (result.pilots.choices.size() != 1) {
    ADD_FAILURE() << result.pilots.choices.size() << " choices";
    return "";
  }
  const StrategyChoice& choice = result.pilots.choices[0];
  const auto least =
      std::min_element(choice.scores.begin(), choice.scores.end(),
                       [](const auto& a, const auto& b) { return Product(a) < Product(b); });
  EXPECT_EQ(choice.scores[0].name, "importance");
  if (least->name != choice.chosen) {
    EXPECT_EQ(choice.chosen, "importance");
    EXPECT_GT(Product(*least), 0.9 * Product(choice.scores[0]));
  }
  return choice.chosen;
}

TEST(StrategyPilot, TheChosenStrategyRenders) {
  // Nothing hides the map of the furnace; in the room walls hide most of it.
  const Rendered open = RenderOpen("auto");
  EXPECT_EQ(Chosen(open.result), "importance");
  EXPECT_EQ(open.sums, RenderOpen("importance").sums);
  JobRequest request = Request("auto");
  request.integrator = Integrator::kDirect;
  const Rendered inside = RenderInside(request);
  EXPECT_EQ(Chosen(inside.result), "visibility");
  request.strategy = "visibility";
  EXPECT_EQ(inside.sums, RenderInside(request).sums);
}

TEST(StrategyPilot, ContinuationsHaveAChoiceOfTheirOwn) {
  JobRequest request = Request("importance");
  request.options.bsdf_samples = 3;
  request.continuation_strategy = "auto";
  const Rendered chosen = RenderInside(request);
  const std::string name = Chosen(chosen.result);
  EXPECT_NE(name, "");
  request.continuation_strategy = name;
  EXPECT_EQ(chosen.sums, RenderInside(request).sums);
}

TEST(StrategyPilot, DependsOnNeitherThreadsNorWavesNorParts) {
  const RenderJob job(RoomUnderSkylight(), Request("auto"));
  const Rendered reference = Render(job, job.frame());
  const std::vector<CandidateScore>& scores = reference.result.pilots.choices.at(0).scores;
  const auto expect_same = [&](const FrameView& frame) {
    const StrategyChoice choice = Render(job, frame).result.pilots.choices.at(0);
    ASSERT_EQ(choice.scores.size(), scores.size());
    for (std::size_t i = 0; i < scores.size(); ++i) {
      EXPECT_EQ(choice.scores[i].variance, scores[i].variance) << scores[i].name;
      EXPECT_EQ(choice.scores[i].cost, scores[i].cost) << scores[i].name;
    }
  };
  FrameView frame = job.frame();
  frame.options.threads = 1;
  expect_same(frame);
  frame = job.frame();
  frame.options.wave = 40;
  expect_same(frame);
  frame = job.frame();
  frame.options.picture_samples = {0, 4};
  frame.options.first_sample = 3, frame.options.samples_per_pixel = 1;
  expect_same(frame);
}

TEST(StrategyPilot, LeavesStatisticsToTheFrame) {
  const Rendered rendered = RenderInside(Request("auto"));
  EXPECT_EQ(rendered.result.stats.samples, 64u * 48 * 4);
  EXPECT_EQ(rendered.result.stats.rays[0], 64u * 48 * 4);
  for (const CandidateScore& score : rendered.result.pilots.choices.at(0).scores) {
    EXPECT_GT(score.variance, 0) << score.name;
    EXPECT_GT(score.cost, 2) << score.name;  // the camera ray is one
  }
}

// The irradiance cache is made after the choice, so its pilot has none and follows paths.
TEST(StrategyPilot, ChoosesBeforeThereIsACache) {
  JobRequest request = Request("auto");
  request.integrator = Integrator::kIrradianceCache;
  request.options.of<IrradianceCacheOptions>().rays = 16;
  const Rendered chosen = RenderInside(request);
  request.strategy = Chosen(chosen.result);
  EXPECT_NE(request.strategy, "");
  EXPECT_EQ(chosen.sums, RenderInside(request).sums);
}

TEST(StrategyPilot, NothingIsChosenForLightPaths) {
  JobRequest request = Request("auto");
  request.integrator = Integrator::kPhoton;
  request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic = 100;
  const Rendered photons = RenderInside(request);
  EXPECT_TRUE(photons.result.pilots.choices.empty());
  request.strategy = "importance";
  EXPECT_EQ(photons.sums, RenderInside(request).sums);
}

// A score is 1 for the film, the rays and the light samples of one camera sample, as a frame that
// draws by the candidate counts them. The pilot has other pixels, so about that.
TEST(StrategyPilot, CostsAreThoseOfASample) {
  JobRequest request = Request("auto");
  request.integrator = Integrator::kDirect;
  const FrameResult chosen = RenderInside(request).result;
  request.strategy = "importance";
  const RenderStats stats = RenderInside(request).result.stats;
  const double light_samples =
      double(stats.lanes[std::uint32_t(Kernel::kLightSample)].active) / double(stats.samples);
  const double cost = 1 + double(stats.total_rays()) / double(stats.samples) + 0.2 * light_samples;
  EXPECT_NEAR(chosen.pilots.choices.at(0).scores.at(0).cost / cost, 1, 0.05);
}

}  // namespace
}  // namespace skywave
