// Tests the suite of skywave bench: pictures are distinguished, and figures follow from the
// measurements.
#include "bench/measure/suite.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "bench/measure/bars.h"
#include "bench/measure/counters.h"
#include "tests/support/xml.h"

namespace skywave {
namespace {

constexpr SuiteScene kTiny = {"spheres", 40, 30, 2, {}};

JobRequest OnThreads(int threads) {
  JobRequest request;
  request.options.threads = threads;
  return request;
}

Fingerprint Render(const SuiteScene& scene, JobRequest base) {
  const RenderJob job(SuiteRequest(scene, base));
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  return FingerprintOf(film, scene.samples_per_pixel);
}

TEST(Fingerprint, DependsOnThePictureAlone) {
  JobRequest other = OnThreads(3);
  other.options.wave = 17, other.options.backend = Backend::kSingle;
  const Fingerprint a = Render(kTiny, OnThreads(1)), b = Render(kTiny, other);
  EXPECT_EQ(a.hash, b.hash);
  EXPECT_EQ(a.means, b.means);
  other.options.seed = 1;
  const Fingerprint c = Render(kTiny, other);
  EXPECT_NE(a.hash, c.hash);
  EXPECT_GT(BlockDifference(a, c), kPictureBound);
}

TEST(Fingerprint, MeansAreThoseOfTheBlocks) {
  const RenderJob job(SuiteRequest(kTiny, OnThreads(0)));
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  const Image image = film.Resolve(2);
  double sum = 0;  // block of columns 10-19 and rows 15-21: pixels with y * 4 / 30 == 2
  int count = 0;
  for (int y = 15; y * 4 / 30 == 2; ++y) {
    for (int x = 10; x < 20; ++x, count += 3) {
      for (int channel = 0; channel < 3; ++channel) sum += image.Pixel(x, y)[channel];
    }
  }
  EXPECT_NEAR(FingerprintOf(film, 2).means[2 * 4 + 1], sum / count, 1e-6);
}

TEST(CheckPicture, WantsTheSameBitsOrBoundsWhereHitsDiffer) {
  Fingerprint expected = {.hash = 5, .means = {}};
  expected.means.fill(0.5f);
  Fingerprint other = expected;
  EXPECT_EQ(CheckPicture(expected, other, 5), PictureCheck::kSameBits);
  EXPECT_EQ(CheckPicture(expected, other, 6), PictureCheck::kWrong);
  other.hash = 6;
  EXPECT_EQ(CheckPicture(expected, other, 5), PictureCheck::kWrong);
  EXPECT_EQ(CheckPicture(expected, other, 6), PictureCheck::kSameBits);
  EXPECT_EQ(CheckPicture(expected, other, std::nullopt), PictureCheck::kWithinBounds);
  other.means[3] = 0.5f * float(1 - 1.1 * kPictureBound);
  EXPECT_EQ(CheckPicture(expected, other, std::nullopt), PictureCheck::kWrong);
  other.means[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(CheckPicture(expected, other, std::nullopt), PictureCheck::kWrong);
}

TEST(CheckPicture, OtherInstructionSetsStayWithinBounds) {
  JobRequest request;
  request.embree_config = "isa=sse2";
  const SuiteScene& scene = SuiteScenes(false)[1];
  ASSERT_EQ(scene.name, "spheres");
  EXPECT_FALSE(KnownHash(scene, request).has_value());
  EXPECT_LT(BlockDifference(scene.expected, Render(scene, request)), 0.1 * kPictureBound);
}

// Returns a result with known times.
SuiteResult Result(double render) {
  SuiteResult result;
  result.speed.first.stats.samples = 2000000;
  result.speed.first.stats.rays = {2000000, 3000000, 1000000};
  result.speed.render = {render, render * 10, render / 10};
  result.speed.scaling = {{1, {render * 3, render * 2, render}}, {2, {render}}};
  // Calls 0 and 1 have times for camera, bounce and shadow rays.
  result.speed.replay[0][0] = {{{0.1, 0.1, 9}, {0.2}, {0.2}}};
  result.speed.replay[0][1] = {{{0.2}, {0.3}, {0.1, 0.1, 0.9}}};
  result.speed.replay[2][0] = {{{0.05}, {0.05}, {0.1}}};
  result.speed.first.threads = 2;
  result.speed.traces = {{0.5, 1, 0.25}, {4, 3, 2}, {0.4, 0.2, 0.1}};
  return result;
}

TEST(Speed, CeilingIsTheBestCallForEachKindOfRay) {
  const SuiteResult result = Result(0.5);
  EXPECT_DOUBLE_EQ(result.speed.best_replay_seconds(RayOrder::kTraced), 0.4);
  EXPECT_DOUBLE_EQ(result.speed.best_replay_seconds(RayOrder::kFrame), 0.2);
  EXPECT_EQ(result.speed.best_replay_seconds(RayOrder::kWave), 0);
  EXPECT_DOUBLE_EQ(result.speed.embree_fraction(), 0.8);
  EXPECT_DOUBLE_EQ(result.speed.speed_up(2), 2);
  EXPECT_EQ(result.speed.speed_up(4), 0);
  EXPECT_DOUBLE_EQ(result.msamples_per_second(), 4);
  EXPECT_DOUBLE_EQ(result.mrays_per_second(), 12);
}

// Threads of a render of 40 us wait half of their time, however quiet the machine is.
TEST(Suite, DoubtsOfShortRendersSayThatTheyAreShort) {
  Speed speed;
  speed.render = {4e-5, 4e-5, 4e-5};
  EXPECT_TRUE(speed.doubts().empty());
  speed.conditions.waiting = 0.4;
  ASSERT_EQ(speed.doubts().size(), 2u);
  EXPECT_NE(speed.doubts()[0].find("a render takes 0.04 ms"), std::string::npos);
  speed.render = {0.4, 0.4, 0.4};
  EXPECT_EQ(speed.doubts().size(), 1u);
}

TEST(Speed, RaysOfAKindAreThoseOfTheRenderWhileTracingAndRaw) {
  const Speed speed = Result(0.5).speed;
  EXPECT_DOUBLE_EQ(speed.mrays_per_second(RayKind::kCamera), 4);
  EXPECT_DOUBLE_EQ(speed.mrays_per_second(RayKind::kShadow), 2);
  // Each of two threads spends half a second.
  EXPECT_DOUBLE_EQ(speed.traced_mrays_per_second(RayKind::kCamera), 8);
  EXPECT_DOUBLE_EQ(speed.traced_mrays_per_second(RayKind::kBounce), 6);
  EXPECT_DOUBLE_EQ(speed.raw_mrays_per_second(RayKind::kCamera), 20);
  EXPECT_DOUBLE_EQ(speed.raw_mrays_per_second(RayKind::kBounce), 15);
  EXPECT_DOUBLE_EQ(speed.raw_mrays_per_second(RayKind::kShadow), 10);
  EXPECT_EQ(speed.best_replay(RayOrder::kTraced, RayKind::kBounce).call, kBackends[0]);
  EXPECT_EQ(speed.best_replay(RayOrder::kTraced, RayKind::kShadow).call, kBackends[1]);
  EXPECT_EQ(Speed().raw_mrays_per_second(RayKind::kCamera), 0);
}

TEST(Summarize, TakesGeometricMeansOverScenes) {
  std::vector<SuiteResult> results = {Result(0.5), Result(2)};
  EXPECT_NEAR(Summarize(results).msamples_per_s, 2, 1e-12);  // geometric mean of 4 and 1
  EXPECT_NEAR(Summarize(results).embree_fraction, 0.4, 1e-12);
  EXPECT_NEAR(Summarize(results).scaling_2, 2, 1e-12);
  results[1].speed.scaling.clear();
  EXPECT_EQ(Summarize(results).scaling_2, 0);
}

TEST(MeasureSpeed, KeepsEveryRepetition) {
  const RenderJob job(SuiteRequest(kTiny, OnThreads(2)));
  Film film = job.MakeFilm();
  const Speed speed = MeasureSpeed(job, {.repetitions = 3, .thread_counts = {1, 3}}, film);
  EXPECT_EQ(speed.render.size(), 3u);
  EXPECT_EQ(speed.stages.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    // All tracing belongs to some kind of rays.
    const double stages = speed.stages.at(i)[std::uint32_t(Stage::kIntersect)] +
                          speed.stages.at(i)[std::uint32_t(Stage::kShadow)];
    EXPECT_NEAR(speed.traces.at(i)[0] + speed.traces.at(i)[1] + speed.traces.at(i)[2], stages,
                1e-9);
  }
  ASSERT_EQ(speed.scaling.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(speed.scaling[i].threads, i + 1);
    EXPECT_EQ(speed.scaling[i].render.size(), 3u);
  }
  EXPECT_EQ(speed.scaling[1].render, speed.render);
  for (int order = 0; order < kRayOrders; ++order) {
    for (int call = 0; call < kReplayCalls; ++call) {
      for (const auto& seconds : speed.replay[order][call]) EXPECT_EQ(seconds.size(), 3u);
    }
  }
  EXPECT_EQ(FingerprintOf(film, 2).hash, Render(kTiny, OnThreads(0)).hash);
}

// Lanes and rows in use come before those that there are.
TEST(Counters, PrintUsedBeforeAvailable) {
  RenderStats stats;
  stats.samples = 12, stats.waves = 2;
  stats.rays = {12, 7, 5};
  stats.bounces[0] = {.rows = 12, .capacity = 16};
  stats.bounces[1] = {.rows = 7, .capacity = 12};
  const StrategyTable table = {.name = "importance", .bytes = 99};
  std::map<std::string, std::string> counters;
  for (const auto& [name, value] : Counters({.picture = 0xab,
                                   .scene = 0xcd,
                                   .triangles = 3,
                                   .geometry_bytes = 400,
                                   .stats = stats,
                                   .tables = std::span(&table, 1)})) {
    EXPECT_TRUE(counters.emplace(name, value).second) << name;
  }
  const std::map<std::string, std::string> expected = {{"picture", "00000000000000ab"},
                                                       {"scene", "00000000000000cd"},
                                                       {"triangles", "3"},
                                                       {"geometry_bytes", "400"},
                                                       {"samples", "12"},
                                                       {"waves", "2"},
                                                       {"rays camera", "12"},
                                                       {"rays bounce", "7"},
                                                       {"rays shadow", "5"},
                                                       {"bounce 0 rows", "12 of 16"},
                                                       {"bounce 1 rows", "7 of 12"},
                                                       {"clamped_samples", "0"},
                                                       {"invalid_samples", "0"},
                                                       {"table_bytes importance", "99"}};
  EXPECT_EQ(counters, expected);
}

TEST(ScalingThreads, DoubleUpToAll) {
  EXPECT_EQ(ScalingThreads(1), (std::vector<int>{1}));
  EXPECT_EQ(ScalingThreads(2), (std::vector<int>{1, 2}));
  EXPECT_EQ(ScalingThreads(6), (std::vector<int>{1, 2, 4, 6}));
}

TEST(Bars, AreAsLongAsTheirValues) {
  const BarChart chart = {.title = "a < b",
                          .unit = "ms",
                          .segments = {"x & y", "z"},
                          .bars = {{"one", {1, 3}}, {"two", {2, -1}}, {"three", {NAN, 0}}}};
  const std::string svg = Svg(chart);
  EXPECT_TRUE(IsWellFormedXml(svg)) << svg;
  // 634 pixels stand for 4: a quarter, three quarters, and half of them for the second bar.
  for (const char* const width : {"width=\"158.50\"", "width=\"475.50\"", "width=\"317.00\""}) {
    EXPECT_NE(svg.find(width), std::string::npos) << width << "\n" << svg;
  }
  // Ticks from 0 on are 0.5 apart, and a bar of 4 ends at the last of them.
  for (const auto& [label, x] : {std::pair("0", "190.0"), std::pair("1", "348.5"),
                                 std::pair("2.5", "586.2"), std::pair("4", "824.0")}) {
    const std::string tick = std::string("<text x=\"") + x +
                             "\" y=\"133.0\" text-anchor=\"middle\" font-size=\"12\">" + label +
                             "<";
    EXPECT_NE(svg.find(tick), std::string::npos) << tick << "\n" << svg;
  }
  EXPECT_TRUE(IsWellFormedXml(Svg(BarChart{.title = "none", .unit = ""})));
}

}  // namespace
}  // namespace skywave
