// Tests guided paths: their directions, and their pictures.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/screens_scene.h"
#include "tests/support/statistics.h"
#include "wavefront/guiding/bounce_pilot.h"
#include "wavefront/render.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

// ---- Directions ----

constexpr std::uint32_t kRows = 4096;

// Learns from rays that leave a slanting surface everywhere in a box; a tenth of the hemisphere is
// bright.
BounceGuide SlantingGuide() {
  const std::array<float, 3> normal = {0.48f, 0.8f, 0.36f};
  const PlaceBox box = {{0, 0, 0}, 1};
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1), both(-1, 1);
  std::vector<BounceRay> rays;
  while (rays.size() < 20000) {
    std::array<float, 3> d = {both(random), both(random), both(random)};
    const float length = std::hypot(d[0], d[1], d[2]);
    if (length > 1 || length < 0.1f) continue;
    for (float& x : d) x /= length;
    if (d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2] < 0.01f) continue;
    const PlaceWord place =
        PackPlace(box, {uniform(random), uniform(random), uniform(random)}, normal);
    rays.push_back({place, d, d[0] > 0.8f ? 5.0f : 0.2f});
  }
  return {rays, box};
}

// Surfaces of one place, and columns for what kernels write.
struct GuidedRows {
  GuidedRows() : surfaces(kRows), directions(kRows), uniforms(kRows), guide(kRows) {
    for (std::uint32_t i = 0; i < kRows; ++i) {
      surfaces->org_x[i] = 0.3f, surfaces->org_y[i] = 0.6f, surfaces->org_z[i] = 0.9f;
      surfaces->ns_x[i] = 0.48f, surfaces->ns_y[i] = 0.8f, surfaces->ns_z[i] = 0.36f;
    }
  }
  soa::Table<SurfaceColumns> surfaces;
  soa::Table<LightColumns> directions;
  soa::Table<UniformColumns> uniforms;
  soa::Table<GuideColumns> guide;
};

TEST(BounceGuide, DrawsItsDensity) {
  constexpr int kHeights = 16, kTurns = 32, kSteps = 32, kDraws = 8;
  const BounceGuide learnt = SlantingGuide();
  const BounceGuideView view = learnt.view();
  GuidedRows rows;
  FindPlaces(view.places, kRows, rows.surfaces, rows.guide->place);
  FindGuideShares(view, kRows, rows.guide);
  EXPECT_GT(rows.guide->share[0], 0);

  // The sphere is cut into parts of equal size, over which the density is integrated.
  std::vector<double> expected(kHeights * kTurns), observed(kHeights * kTurns);
  const auto set = [&](std::uint32_t row, double height, double turn) {
    const double sine = std::sqrt(1 - height * height), angle = 2 * std::numbers::pi * turn;
    rows.directions->dir_x[row] = float(sine * std::cos(angle));
    rows.directions->dir_y[row] = float(height);
    rows.directions->dir_z[row] = float(sine * std::sin(angle));
  };
  const double size = 4 * std::numbers::pi / double(expected.size() * kSteps * kSteps);
  double bright = 0;
  for (int part = 0; part < kHeights * kTurns; ++part) {
    for (int i = 0; i < kSteps * kSteps; ++i) {
      set(std::uint32_t(i), 2 * (part / kTurns + (i / kSteps + 0.5) / kSteps) / kHeights - 1,
          (part % kTurns + (i % kSteps + 0.5) / kSteps) / kTurns);
    }
    FindGuideDensities(view, kSteps * kSteps, rows.directions, rows.guide);
    for (int i = 0; i < kSteps * kSteps; ++i) {
      expected[std::size_t(part)] += double(rows.guide->pdf[i]) * size;
      if (rows.directions->dir_x[i] > 0.8f) bright += double(rows.guide->pdf[i]) * size;
    }
  }
  double sum = 0;
  for (const double share : expected) sum += share;
  EXPECT_NEAR(sum, 1, 0.003);
  EXPECT_GT(bright, 0.6);

  std::mt19937 random(9);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<std::uint32_t> all(kRows);
  for (std::uint32_t i = 0; i < kRows; ++i) all[i] = i;
  for (int draw = 0; draw < kDraws; ++draw) {
    for (std::uint32_t i = 0; i < kRows; ++i) {
      rows.uniforms->u[i] = std::min(uniform(random), 0x1.fffffep-1f);
      rows.uniforms->v[i] = std::min(uniform(random), 0x1.fffffep-1f);
    }
    DrawGuided(view, rows.guide, rows.uniforms, all.data(), kRows, rows.directions);
    FindGuideDensities(view, kRows, rows.directions, rows.guide);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const LightColumns& d = rows.directions;
      ASSERT_GT(rows.guide->pdf[i], 0);
      ASSERT_NEAR(std::hypot(d.dir_x[i], d.dir_y[i], d.dir_z[i]), 1, 1e-5);
      const double turn = std::atan2(d.dir_z[i], d.dir_x[i]) / (2 * std::numbers::pi);
      const int height = std::clamp(int((double(d.dir_y[i]) + 1) / 2 * kHeights), 0, kHeights - 1);
      const int across = int((turn < 0 ? turn + 1 : turn) * kTurns) % kTurns;
      ++observed[std::size_t(height * kTurns + across)];
    }
  }
  for (double& share : expected) share *= double(kRows) * kDraws / sum;
  EXPECT_TRUE(MatchesExpected(observed, expected, 0.01, /*strays=*/5));
}

// Rays leave one point that faces z, evenly over the disk below the hemisphere. Those to the right
// bring 1 each, those to the left 0 and `most` by turns, which is 1 on average if that is 2.
BounceGuide HalvesGuide(float most) {
  const PlaceBox box = {{0, 0, 0}, 1};
  const PlaceWord place = PackPlace(box, {0.3f, 0.6f, 0.9f}, {0, 0, 1});
  std::mt19937 random(7);
  std::uniform_real_distribution<float> both(-1, 1);
  std::vector<BounceRay> rays;
  while (rays.size() < 80000) {
    const float x = both(random), y = both(random);
    if (x * x + y * y >= 0.999f) continue;
    const float left = rays.size() % 2 == 0 ? most : 0.0f;
    rays.push_back({place, {x, y, std::sqrt(1 - x * x - y * y)}, x > 0 ? 1.0f : left});
  }
  return {rays, box};
}

// Returns the densities of directions all over the disk, over that of the cosine.
std::vector<double> DensitiesOnTheDisk(const BounceGuide& guide, std::vector<float>& x) {
  GuidedRows rows;
  for (std::uint32_t i = 0; i < kRows; ++i) {
    rows.surfaces->ns_x[i] = rows.surfaces->ns_y[i] = 0, rows.surfaces->ns_z[i] = 1;
    // A spiral of equal steps in area.
    const double area = (i + 0.5) / kRows, turn = i * 0.38196601125;
    const double angle = 2 * std::numbers::pi * turn;
    rows.directions->dir_x[i] = float(std::sqrt(area) * std::cos(angle));
    rows.directions->dir_y[i] = float(std::sqrt(area) * std::sin(angle));
    rows.directions->dir_z[i] = float(std::sqrt(1 - area));
    x.push_back(rows.directions->dir_x[i]);
  }
  FindPlaces(guide.view().places, kRows, rows.surfaces, rows.guide->place);
  FindGuideDensities(guide.view(), kRows, rows.directions, rows.guide);
  std::vector<double> densities;
  for (std::uint32_t i = 0; i < kRows; ++i) {
    densities.push_back(double(rows.guide->pdf[i]) * std::numbers::pi /
                        double(rows.directions->dir_z[i]));
  }
  return densities;
}

// Directions are drawn in proportion to the root of the second moment of their light, which has the
// least variance, but a tenth of them evenly.
TEST(BounceGuide, DrawsInProportionToTheSecondMoment) {
  for (const float most : {2.0f, 0.0f}) {
    SCOPED_TRACE(most);
    std::vector<float> x;
    const std::vector<double> densities = DensitiesOnTheDisk(HalvesGuide(most), x);
    const double root = std::sqrt(0.5) * double(most);  // of the left
    double left = 0, least = 1;
    for (std::uint32_t i = 0; i < kRows; ++i) {
      least = std::min(least, densities[i]);
      if (x[i] < 0) left += densities[i] / kRows;
    }
    EXPECT_NEAR(left, 0.05 + 0.9 * root / (1 + root), 0.01);
    EXPECT_GT(least, 0.09);
  }
}

// A place with few rays expects what the node above has seen, in the same directions of the world,
// though its own hemisphere leans: light comes from positive x.
TEST(BounceGuide, ExpectsTheLightOfTheNodeAbove) {
  const PlaceBox box = {{0, 0, 0}, 1};
  const std::array<float, 3> leaning = {0.6f, 0, 0.8f};
  std::mt19937 random(11);
  std::uniform_real_distribution<float> both(-1, 1);
  std::vector<BounceRay> rays;
  while (rays.size() < 80000) {
    const float x = both(random), y = both(random);
    if (x * x + y * y >= 0.999f) continue;
    const PlaceWord place = rays.size() < 79990 ? PackPlace(box, {0.3f, 0.6f, 0.9f}, {0, 0, 1})
                                                : PackPlace(box, {0.8f, 0.2f, 0.1f}, leaning);
    rays.push_back({place, {x, y, std::sqrt(1 - x * x - y * y)}, float(x > 0)});
  }
  const BounceGuide guide(rays, box);
  GuidedRows rows;
  for (std::uint32_t i = 0; i < kRows; ++i) {
    rows.surfaces->org_x[i] = 0.8f, rows.surfaces->org_y[i] = 0.2f, rows.surfaces->org_z[i] = 0.1f;
    rows.surfaces->ns_x[i] = leaning[0], rows.surfaces->ns_y[i] = 0;
    rows.surfaces->ns_z[i] = leaning[2];
    // Both sides of the border of the light, near z.
    rows.directions->dir_x[i] = i % 2 == 0 ? 0.3f : -0.3f;
    rows.directions->dir_y[i] = float(i) / kRows - 0.5f;
    rows.directions->dir_z[i] = std::sqrt(0.91f - std::pow(float(i) / kRows - 0.5f, 2.0f));
  }
  FindPlaces(guide.view().places, kRows, rows.surfaces, rows.guide->place);
  FindGuideDensities(guide.view(), kRows, rows.directions, rows.guide);
  double bright = 0, dark = 0;
  for (std::uint32_t i = 0; i < kRows; ++i) {
    const double cosine = double(leaning[0]) * double(rows.directions->dir_x[i]) +
                          double(leaning[2]) * double(rows.directions->dir_z[i]);
    const double density = double(rows.guide->pdf[i]) * std::numbers::pi / cosine / (kRows / 2);
    (i % 2 == 0 ? bright : dark) += density;
  }
  // The bright directions are four fifths of the leaning hemisphere.
  EXPECT_NEAR(bright, 0.1 + 0.9 / 0.8, 0.1);
  EXPECT_LT(dark, 0.3);
}

// Roulette ends some paths, and the others carry their light, also where all of them go on.
TEST(BounceGuide, RouletteKeepsTheMeanOfPaths) {
  GuidedRows rows;
  const soa::Table<BsdfValueColumns> values(kRows);
  const soa::Table<RayColumns> rays(kRows);
  std::vector<float> roulette(PaddedRows(kRows));
  for (const float throughput : {0.9f, 0.3f, 0.04f}) {
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const SurfaceColumns& s = rows.surfaces;
      s.ng_x[i] = s.ns_x[i], s.ng_y[i] = s.ns_y[i], s.ng_z[i] = s.ns_z[i];
      s.wo_x[i] = s.ns_x[i], s.wo_y[i] = s.ns_y[i], s.wo_z[i] = s.ns_z[i];
      s.throughput_r[i] = throughput, s.throughput_g[i] = 0.5f * throughput;
      s.throughput_b[i] = 0;
      s.lift[i] = 0, s.path[i] = i;
      rows.directions->dir_x[i] = s.ns_x[i], rows.directions->dir_y[i] = s.ns_y[i];
      rows.directions->dir_z[i] = s.ns_z[i];
      values->r[i] = values->g[i] = values->b[i] = 0.4f, values->pdf[i] = 0.3f;
      rows.guide->share[i] = 0.5f, rows.guide->pdf[i] = 0.7f;
      roulette[i] = (float(i) + 0.5f) / kRows;
    }
    const double mean = double(throughput) * 0.4 / (0.5 * 0.3 + 0.5 * 0.7);
    for (const bool plays : {false, true}) {
      const std::uint32_t count =
          ScatterGuided(rows.surfaces, rows.guide, values, rows.directions, roulette.data(), kRows,
                        {.roulette = plays}, rays, 0);
      double red = 0, green = 0;
      for (std::uint32_t i = 0; i < count; ++i) {
        red += double(rays->throughput_r[i]) / kRows;
        green += double(rays->throughput_g[i]) / kRows;
        ASSERT_NEAR(rays->pdf[i], 0.5f, 1e-6);
      }
      EXPECT_NEAR(red / mean, 1, 2e-3) << throughput << plays;
      EXPECT_NEAR(green / mean, 0.5, 1e-3) << throughput << plays;
      EXPECT_NEAR(count, kRows * (plays ? std::min(1.0, 4 * mean) : 1.0), 1) << throughput;
    }
  }
}

// Metals and sharp highlights are left to the BSDF, all others lose nothing to it.
TEST(BounceGuide, SharesNoDirectionsOfGloss) {
  constexpr std::uint32_t kCount = 101;
  GuidedRows rows;
  const auto shares = [&](auto width, auto metal) {
    for (std::uint32_t i = 0; i < kCount; ++i) {
      rows.guide->share[i] = 0.5f;
      rows.surfaces->varying_0[i] = width(i), rows.surfaces->varying_1[i] = metal(i);
    }
    LeaveGlossToBsdf(rows.surfaces, kCount, rows.guide);
    return std::vector<float>(rows.guide->share, rows.guide->share + kCount);
  };
  const auto grows = [](std::uint32_t i) { return float(i) / (kCount - 1); };
  const std::vector<float> by_width = shares(grows, [](std::uint32_t) { return 0.0f; });
  EXPECT_TRUE(std::is_sorted(by_width.begin(), by_width.end()));
  EXPECT_EQ(by_width[10], 0);
  EXPECT_EQ(by_width[80], 0.5f);
  const std::vector<float> by_metal = shares([](std::uint32_t) { return 1.0f; }, grows);
  EXPECT_TRUE(std::is_sorted(by_metal.rbegin(), by_metal.rend()));
  EXPECT_EQ(by_metal.front(), 0.5f);
  EXPECT_NEAR(by_metal[50], 0.25f, 1e-6);
  EXPECT_EQ(by_metal.back(), 0);
}

TEST(BounceGuide, TheRestOfAUniformIsUniform) {
  GuidedRows rows;
  for (std::uint32_t i = 0; i < kRows; ++i) {
    rows.guide->share[i] = 0.3f;
    rows.uniforms->u[i] = (float(i) + 0.5f) / kRows;
  }
  std::vector<std::uint32_t> guided(kRows + kPadRows);
  const std::uint32_t count = ChooseGuided(rows.guide, kRows, rows.uniforms, guided.data());
  EXPECT_NEAR(count, 0.3 * kRows, 1);
  std::vector<float> rest(rows.uniforms->u + count, rows.uniforms->u + kRows);
  for (std::uint32_t i = 0; i < count; ++i) EXPECT_EQ(guided[i], i);
  EXPECT_TRUE(IsUniform({rows.uniforms->u, count}, 0.01));
  EXPECT_TRUE(IsUniform(rest, 0.01));
}

// ---- Pictures ----

// A room with an opening in its roof under a sky with a sun, seen from inside.
Scene Room(bool lamps) {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "white", glm::vec3(0.7f));
  scene.materials.push_back({.name = "clay", .bsdf = BsdfKind::kOrenNayar, .alpha = 0.8f});
  scene.materials.push_back(
      {.name = "plastic", .bsdf = BsdfKind::kMetallicRoughness, .alpha = 0.3f, .metallic = 0.3f});
  PlaceRoom(scene, white);
  Place(scene, Sphere(0.3f, 3), 1, {0.3f, 0.4f, 0.4f});
  Place(scene, Sphere(0.3f, 3), 2, {-0.6f, 0.4f, -0.5f});
  Place(scene, Quad(0.2f), AddMirror(scene, 0.9f), {0.2f, 1.2f, 0});
  scene.camera = LookAtCamera({1.2f, 1.2f, 1.5f}, {-0.3f, 0.5f, -0.4f}, {0, 1, 0}, 70, false);
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  if (lamps) scene.lights = {SlantingSpot()};
  return scene;
}

JobRequest Request(bool guided, std::uint32_t samples = 16) {
  JobRequest request = SmallRequest(32, 24, samples);
  request.integrator = Integrator::kPath;
  request.max_depth = 6;
  request.options.guide_bounces = guided;
  return request;
}

std::vector<std::uint64_t> Render(const RenderJob& job, const FrameView& frame) {
  Film film = job.MakeFilm();
  RenderFrame(frame, film);
  return {film.sums().begin(), film.sums().end()};
}

TEST(BouncePilot, PicturesDependOnNeitherThreadsNorWavesNorParts) {
  JobRequest request = Request(true);
  request.strategy = "visibility";
  const RenderJob job(Room(true), request);
  const std::vector<std::uint64_t> reference = Render(job, job.frame());
  for (const int threads : {1, 3}) {
    FrameView frame = job.frame();
    frame.options.threads = threads, frame.options.wave = threads == 1 ? 24 : 1232;
    EXPECT_EQ(Render(job, frame), reference) << threads;
  }
  std::vector<std::uint64_t> sums(reference.size());
  for (const std::uint32_t first : {0u, 7u}) {
    FrameView frame = job.frame();
    frame.options.first_sample = first, frame.options.samples_per_pixel = first == 0 ? 7 : 9;
    const std::vector<std::uint64_t> part = Render(job, frame);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += part[i];
  }
  EXPECT_EQ(sums, reference);

  request.crop = CropWindow{.x = 8, .y = 4, .width = 12, .height = 8};
  const RenderJob part(Room(true), request);
  Film whole = job.MakeFilm(), cropped = part.MakeFilm();
  RenderFrame(job.frame(), whole), RenderFrame(part.frame(), cropped);
  const Image all = whole.Resolve(16), some = cropped.Resolve(16);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 3 * 12; ++x) {
      ASSERT_EQ(some.rgb[std::size_t(y) * 36 + x], all.rgb[std::size_t(y + 4) * 96 + 24 + x]);
    }
  }
}

// Tests that guiding changes nothing but the noise; returns the variances without and with it.
std::array<double, 2> ExpectSameGuided(const Scene& scene, const std::string& strategy,
                                       bool mis = true) {
  PictureEstimate estimates[2];
  std::array<double, 2> variance = {};
  for (const bool guided : {false, true}) {
    JobRequest request = Request(guided);
    request.strategy = strategy, request.options.mis = mis;
    estimates[guided] =
        MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), 12, guided ? 70 : 170), 3);
    for (const double of_channel : estimates[guided].variance) variance[guided] += of_channel;
  }
  EXPECT_TRUE(SamePicture(estimates[0], estimates[1], SidakLevel(8)));
  return variance;
}

TEST(BouncePilot, KeepsGloss) {
  const auto [plain, guided] = ExpectSameGuided(Room(false), "visibility");
  EXPECT_LT(guided, 1.2 * plain);
}
TEST(BouncePilot, LowersTheNoiseOfRooms) {
  const auto [plain, guided] = ExpectSameGuided(BuiltinScene("room"), "visibility");
  EXPECT_LT(guided, 0.9 * plain);
}
TEST(BouncePilot, KeepsLampsBesideTheMap) { ExpectSameGuided(Room(true), "importance"); }
// Light samples are about as dense as those of BSDFs here, so that their weights matter.
TEST(BouncePilot, KeepsTheLightOfAnOpening) {
  Scene scene = Room(false);
  SetLight(scene, SkyWithSun(64, 32, 1, 0.2));
  ExpectSameGuided(scene, "cosine");
}
TEST(BouncePilot, KeepsLightSamplesAlone) {
  ExpectSameGuided(Room(false), "importance:compensate=0", false);
}
TEST(BouncePilot, KeepsEveryMaterial) { ExpectSameGuided(BuiltinScene("materials"), "importance"); }
TEST(BouncePilot, KeepsScreensAndNormalMaps) { ExpectSameGuided(ScreensScene(), "importance"); }

TEST(BouncePilot, UnsupportedCombinationsAreRefused) {
  for (const Integrator integrator : {Integrator::kDirect, Integrator::kBdpt}) {
    JobRequest request = Request(true);
    request.integrator = integrator;
    EXPECT_THROW(RenderJob(Room(false), request), OptionError);
  }
  JobRequest split = Request(true), controlled = Request(true);
  split.options.split = 2, controlled.options.control = ControlVariate::kIrradiance;
  EXPECT_THROW(RenderJob(Room(false), split), OptionError);
  EXPECT_THROW(RenderJob(Room(false), controlled), OptionError);
}

}  // namespace
}  // namespace skywave
