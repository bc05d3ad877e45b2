// Tests paths that split at their first hit: they give the same picture with less noise in the
// split parts, and the same bits however the work is divided.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "tests/support/matt_room.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/room_lights.h"
#include "tests/support/screens_scene.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"
#include "wavefront/integrators/path.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr int kRuns = 12;
constexpr std::uint32_t kSamples = 8;  // per run
// This many comparisons of pictures share the level of the test program.
const double kLevel = SidakLevel(20);

// Returns a matt, a metallic and a glass ball and a mirror facing each other on a floor.
Scene Balls() {
  Scene scene;
  Place(scene, Quad(8), AddLambert(scene, "floor", {0.5f, 0.55f, 0.6f}), glm::vec3(0));
  scene.materials.push_back({.name = "gold",
                             .bsdf = BsdfKind::kConductor,
                             .eta = {0.143f, 0.375f, 1.442f},
                             .k = {3.983f, 2.386f, 1.603f},
                             .alpha = 0.2f});
  const auto gold = std::uint32_t(scene.materials.size() - 1);
  Place(scene, Sphere(0.6f, 5), AddLambert(scene, "red", {0.8f, 0.3f, 0.2f}), {-1.3f, 0.6f, 0});
  Place(scene, Sphere(0.6f, 5), gold, {0, 0.6f, -0.3f});
  Place(scene, Sphere(0.6f, 5), AddGlass(scene, 1.5f), {1.3f, 0.6f, 0});
  Place(scene, Sphere(0.3f, 5), AddMirror(scene, 0.9f), {0.3f, 0.3f, 1.2f});
  scene.camera = LookAtCamera({0.4f, 1.9f, 4.5f}, {0, 0.5f, 0}, {0, 1, 0}, 40, false);
  return scene;
}

JobRequest Request(std::uint32_t split, std::uint32_t light_samples, std::uint32_t max_depth) {
  JobRequest request = SmallRequest(32, 24, kSamples);
  request.max_depth = max_depth;
  request.options.bsdf_samples = split;
  request.options.light_samples = light_samples;
  request.strategy = "importance:compensate=0";  // by default it depends on the light samples
  return request;
}

Film Render(const RenderJob& job, const FrameView& frame) {
  Film film = job.MakeFilm();
  RenderFrame(frame, film);
  return film;
}
std::vector<std::uint64_t> Sums(const Film& film) {
  return {film.sums().begin(), film.sums().end()};
}

void ExpectOracles(const Scene& scene, const JobRequest& request) {
  const RenderJob job(scene, request);
  EXPECT_TRUE(SamePicture(EstimateFromEngine(job, kRuns, 100),
                          EstimateFromOracle(scene, job, 4 * kRuns), kLevel));
}

TEST(Split, PicturesMatchTheOracleAtEveryDepth) {
  Scene scene = Balls();
  SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
  for (const std::uint32_t depth : {0u, 1u, 2u, 3u, 8u}) {
    SCOPED_TRACE(depth);
    ExpectOracles(scene, Request(3, 2, depth));
  }
}

TEST(Split, PicturesWithoutMisMatchTheOracle) {
  Scene scene = Balls();
  SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
  JobRequest request = Request(4, 3, 5);
  request.options.mis = false;
  ExpectOracles(scene, request);
}

TEST(Split, PicturesWithLocalLightsAndAlphaMatchTheOracle) {
  Scene scene = ScreensScene();
  for (Material& material : scene.materials) {
    if (material.opaque()) continue;
    material.emission = {0.9f, 1.5f, 2};
  }
  ExpectOracles(scene, Request(4, 2, 3));
}

// Another strategy lights everything after the first hit: rays from there to the environment are
// weighted against the light samples with which they compete.
TEST(Split, PicturesByTwoStrategiesMatchTheOracle) {
  Scene scene = Balls();
  SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
  for (const auto& [first, behind] :
       {std::pair{"hybrid:lights=8,inside=1", "uniform"},
        std::pair{"bsdf", "hybrid:lights=8,inside=1"}, std::pair{"product", "importance"}}) {
    SCOPED_TRACE(first);
    JobRequest request = Request(4, 3, 4);
    request.strategy = first, request.continuation_strategy = behind;
    ExpectOracles(scene, request);
  }
}

// With direct light alone the first surface takes several BSDF samples, and nothing goes on.
TEST(Split, BsdfSamplesOfDirectLightMatchTheOracle) {
  Scene scene = Balls();
  SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
  JobRequest request = Request(4, 3, 5);
  request.integrator = Integrator::kDirect;
  ExpectOracles(scene, request);
}

TEST(Split, BsdfSamplesOfDirectLightAreThoseOfPathsOfOneSurface) {
  Scene scene = MattRoom(Of(BsdfKind::kConductor), kEnvironment | kLamp);
  JobRequest request = Request(4, 3, 1);
  const RenderJob path(scene, request);
  request.integrator = Integrator::kDirect;
  request.max_depth = 5;
  const RenderJob direct(scene, request);
  EXPECT_EQ(Sums(Render(direct, direct.frame())), Sums(Render(path, path.frame())));
}

// One continuation with one light sample uses the random numbers of a path that does not split.
TEST(Split, SplittingIntoOneEqualsThePath) {
  const Scene scene = BuiltinScene("gallery");
  const RenderJob split(scene, Request(1, 1, 8)), path(scene, Request(0, 1, 8));
  const Image a = Render(split, split.frame()).Resolve(kSamples);
  const Image b = Render(path, path.frame()).Resolve(kSamples);
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    ASSERT_NEAR(a.rgb[i], b.rgb[i], 1e-5f * (1e-3f + b.rgb[i])) << i;
  }
}

// On a plane under a map, radiance depends on nothing but the direction drawn. So N samples that go
// on as S paths each are N S samples: continuations take that many points of one sequence, each of
// them once.
TEST(Split, ContinuationsAreStratifiedAsSamplesAre) {
  Scene scene;
  Place(scene, Quad(50), AddLambert(scene, "floor", glm::vec3(0.7f)), glm::vec3(0));
  scene.camera = LookAtCamera({0, 2, 0}, {0, 0, 0}, {0, 0, 1}, 40, false);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
  const auto picture = [&](std::uint32_t split, std::uint32_t samples) {
    JobRequest request = Request(split, 1, 1);
    request.strategy = "bsdf";  // all light comes by what is drawn at the surface
    request.samples_per_pixel = samples;
    const RenderJob job(scene, request);
    return Render(job, job.frame()).Resolve(samples);
  };
  const Image path = picture(0, 16);
  for (const std::uint32_t split : {2u, 4u, 16u}) {
    const Image image = picture(split, 16 / split);
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
      ASSERT_NEAR(image.rgb[i], path.rgb[i], 1e-5f * path.rgb[i]) << split << ", value " << i;
    }
  }
}

// Sums over the picture: the variance of a sample of the beauty, and the variance over seeds of its
// direct light.
struct Noise {
  double beauty = 0, direct = 0;
};
Noise NoiseOf(const Scene& scene, JobRequest request) {
  request.options.aovs = ParseAovs("variance,direct").value();
  const RenderJob job(scene, request);
  constexpr int kPictures = 8;
  std::map<std::string, std::vector<double>> sums, squares;
  Noise noise;
  for (std::uint32_t seed = 0; seed < kPictures; ++seed) {
    FrameView frame = job.frame();
    frame.options.seed = seed;
    for (const NamedChannel& channel : Render(job, frame).ResolveAovs(kSamples)) {
      auto& sum = sums[channel.name];
      auto& square = squares[channel.name];
      sum.resize(channel.values.size()), square.resize(channel.values.size());
      for (std::size_t i = 0; i < sum.size(); ++i) {
        const double value = channel.values[i];
        sum[i] += value / kPictures, square[i] += value * value / kPictures;
      }
    }
  }
  for (const char* const letter : {"R", "G", "B"}) {
    for (const double mean : sums[std::string("variance.") + letter]) noise.beauty += mean;
    const std::string direct = std::string("direct.") + letter;
    for (std::size_t i = 0; i < sums[direct].size(); ++i) {
      noise.direct += squares[direct][i] - sums[direct][i] * sums[direct][i];
    }
  }
  return noise;
}

TEST(Split, SamplesHaveLessNoise) {
  Scene scene = Balls();
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  const Noise path = NoiseOf(scene, Request(0, 1, 5));
  const Noise light = NoiseOf(scene, Request(1, 16, 5));
  const Noise both = NoiseOf(scene, Request(16, 16, 5));
  // No light sample can reduce this noise, which comes from edges and mirrors.
  const double edges = NoiseOf(scene, Request(1, 128, 5)).direct;
  EXPECT_LT(light.direct - edges, 0.1 * (path.direct - edges));
  EXPECT_LT(both.direct - edges, 0.1 * (path.direct - edges));
  EXPECT_LT(light.beauty, 0.9 * path.beauty);
  EXPECT_LT(both.beauty, 0.6 * light.beauty);
}

TEST(Split, DirectLayerIsThePictureOfOneSurface) {
  for (const bool mis : {true, false}) {
    JobRequest request = Request(3, 2, 6);
    request.options.mis = mis;
    request.options.aovs = ParseAovs("direct,indirect,samples").value();
    const Scene scene = BuiltinScene("gallery");
    const RenderJob job(scene, request);
    const Film film = Render(job, job.frame());
    std::map<std::string, std::vector<float>> layers;
    for (const NamedChannel& c : film.ResolveAovs(kSamples)) layers[c.name] = c.values;
    EXPECT_EQ(layers["samples.V"], std::vector<float>(32 * 24, kSamples));
    request.max_depth = 1;
    const RenderJob shallow(scene, request);
    const Image direct = Render(shallow, shallow.frame()).Resolve(kSamples);
    const Image beauty = film.Resolve(kSamples);
    double indirect = 0;
    for (std::size_t i = 0; i < direct.rgb.size(); ++i) {
      const std::string letter(1, "RGB"[i % 3]);
      ASSERT_EQ(layers["direct." + letter][i / 3], direct.rgb[i]) << i;
      const float rest = layers["indirect." + letter][i / 3];
      ASSERT_NEAR(direct.rgb[i] + rest, beauty.rgb[i], 2e-7 * beauty.rgb[i]);
      indirect += rest;
    }
    EXPECT_GT(indirect, 0);
  }
}

TEST(Split, BitsDoNotDependOnTheCut) {
  for (const char* const name : {"gallery", "lamps"}) {
    JobRequest request = Request(3, 2, 8);
    request.width = 19, request.height = 13, request.samples_per_pixel = 5;
    request.continuation_strategy = "warp";
    const RenderJob job(BuiltinScene(name), request);
    FrameView frame = job.frame();
    frame.options.threads = 1;
    const std::vector<std::uint64_t> reference = Sums(Render(job, frame));
    for (const std::uint32_t wave : {1u, 17u, 256u, 2048u}) {
      for (const Backend backend : {Backend::kPacket, Backend::kSingle}) {
        FrameView cut = job.frame();
        cut.options.wave = wave;
        cut.options.threads = 3;
        cut.tracer.closest = cut.tracer.occlusion = backend;
        EXPECT_EQ(Sums(Render(job, cut)), reference) << name << " " << wave;
      }
    }
    ForEachTarget([&] { EXPECT_EQ(Sums(Render(job, job.frame())), reference); });
    Film merged = job.MakeFilm();
    for (const auto& [first, count] : {std::pair{3u, 2u}, std::pair{0u, 3u}}) {
      frame.options.first_sample = first, frame.options.samples_per_pixel = count;
      merged.Merge(Render(job, frame));
    }
    EXPECT_EQ(Sums(merged), reference);
  }
}

TEST(Split, CountsCameraSamples) {
  const RenderJob job(BuiltinScene("spheres"), Request(4, 1, 3));
  Film film = job.MakeFilm();
  const RenderStats stats = RenderFrame(job.frame(), film).stats;
  EXPECT_EQ(stats.samples, 32u * 24 * kSamples);
  EXPECT_EQ(stats.rays[std::uint32_t(RayKind::kCamera)], stats.samples);
  EXPECT_GT(stats.rays[std::uint32_t(RayKind::kBounce)], 2 * stats.samples);
}

TEST(Split, UnsupportedCombinationsAreRefused) {
  const Scene scene = BuiltinScene("spheres");
  JobRequest bdpt = Request(4, 1, 3);
  bdpt.integrator = Integrator::kBdpt;
  EXPECT_THROW(RenderJob(scene, bdpt), InputError);
  JobRequest direct = Request(4, 1, 3);
  direct.integrator = Integrator::kDirect;
  EXPECT_NO_THROW(RenderJob(scene, direct));
  direct.continuation_strategy = "uniform";
  EXPECT_THROW(RenderJob(scene, direct), InputError);
  JobRequest unsplit = Request(0, 1, 3);
  unsplit.continuation_strategy = "uniform";
  EXPECT_THROW(RenderJob(scene, unsplit), InputError);
  JobRequest many = Request(1 << 16, 1, 3);
  many.samples_per_pixel = 1 << 16;
  EXPECT_THROW(RenderJob(scene, many), InputError);
  many.samples_per_pixel = (1 << 16) - 1;
  EXPECT_NO_THROW(RenderJob(scene, many));
  JobRequest incomplete = Request(4, 1, 3);
  incomplete.continuation_strategy = "bsdf", incomplete.options.mis = false;
  EXPECT_THROW(RenderJob(scene, incomplete), InputError);
}

}  // namespace
}  // namespace skywave
