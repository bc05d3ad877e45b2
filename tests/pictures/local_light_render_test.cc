// Tests pictures lit by local lights against closed forms, the oracle and themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "lights/strategies/strategy.h"
#include "scene/scene_hash.h"
#include "scene/shapes/mesh.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/room_lights.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kRuns = 12;
// This many comparisons of pictures share the level of the test program.
const double kLevel = SidakLevel(120);

// Adds a rectangle in the plane y = height that emits downwards.
void AddLamp(Scene& scene, float width, float depth, const glm::vec3& centre,
             const glm::vec3& radiance, bool upside_down = false) {
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
  scene.materials[lamp].emission = radiance;
  Mesh mesh;
  const glm::vec3 x(width / 2, 0, 0), z(0, 0, depth / 2);
  mesh.positions = {centre - x - z, centre + x - z, centre + x + z, centre - x + z};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  if (upside_down) FlipOrientation(mesh);
  mesh.material = lamp;
  scene.meshes.push_back(mesh);
}

// The closed forms describe a floor of albedo 1, seen at the origin in a tiny field of view.

// The lid above the lights casts no shadow because shadow rays end at their light.
Scene Floor() {
  Scene scene;
  Place(scene, Quad(30), AddLambert(scene, "floor", glm::vec3(1)), glm::vec3(0));
  Place(scene, Quad(30), AddLambert(scene, "lid", glm::vec3(0)), {0, 9, 0});
  scene.camera = LookAtCamera({6, 4, -3}, {0, 0, 0}, {0, 1, 0}, 0.01f, false);
  return scene;
}

// Expects the mean of the picture times pi to be the irradiance at the origin.
void ExpectIrradiance(const Scene& scene, const glm::vec3& expected, bool mis = true,
                      std::uint32_t light_samples = 1) {
  JobRequest request = SmallRequest(4, 4, 64);
  request.integrator = Integrator::kDirect;
  request.max_depth = 1;
  request.options.mis = mis;
  request.options.light_samples = light_samples;
  const RenderJob job(scene, request);
  const PictureEstimate whole = MeanOfBlocks(EstimateFromEngine(job, kRuns, 7), 4);
  for (int c = 0; c < 3; ++c) {
    EXPECT_TRUE(AgreesWith(kPi * whole.mean[c], kPi * std::sqrt(whole.variance[c]), expected[c],
                           1e-4, 1e-3 * expected[c]))
        << "channel " << c << (mis ? "" : " without MIS");
  }
}

// Returns the irradiance from a rectangle of radiance 1 parallel to the floor, with a corner above
// the origin.
double CornerIrradiance(double width, double depth, double height) {
  const double a = width / height, b = depth / height;
  const double ra = std::sqrt(1 + a * a), rb = std::sqrt(1 + b * b);
  return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / 2;
}

TEST(LocalLightIrradiance, APointLightFallsWithTheSquareOfTheDistance) {
  for (const float x : {0.0f, 1.5f, -4.0f}) {
    Scene scene = Floor();
    scene.lights = {{.emission = {3, 5, 7}, .position = {x, 2, 0.5f}}};
    const float d2 = x * x + 4 + 0.25f, cosine = 2 / std::sqrt(d2);
    ExpectIrradiance(scene, glm::vec3(3, 5, 7) * cosine / d2);
    ExpectIrradiance(scene, glm::vec3(3, 5, 7) * cosine / d2, false, 3);
  }
}

TEST(LocalLightIrradiance, ASpotIsFullInsideAndDarkOutside) {
  const auto expect = [](float degrees, double falloff, SpotCurve curve = SpotCurve::kSmoothStep) {
    Scene scene = Floor();
    const float angle = glm::radians(degrees);
    // The spot points away from the origin by that angle; it is full up to 20 degrees and dark from
    // 40.
    scene.lights = {{.kind = LocalLightKind::kSpot,
                     .emission = {8, 4, 2},
                     .position = {0, 3, 0},
                     .direction = {std::sin(angle), -std::cos(angle), 0},
                     .cos_full = std::cos(glm::radians(20.0f)),
                     .cos_dark = std::cos(glm::radians(40.0f)),
                     .curve = curve}};
    ExpectIrradiance(scene, glm::vec3(8, 4, 2) * float(falloff) / 9.0f);
  };
  expect(0, 1), expect(19, 1), expect(41, 0);
  const double c20 = std::cos(kPi / 9), c40 = std::cos(2 * kPi / 9), c30 = std::cos(kPi / 6);
  const double t = (c30 - c40) / (c20 - c40);
  expect(30, t * t * (3 - 2 * t));
  expect(30, t * t, SpotCurve::kSquare), expect(19, 1, SpotCurve::kSquare);
  expect(30, t * t * t * t, SpotCurve::kFourth), expect(41, 0, SpotCurve::kFourth);
}

// The leaf is seen from below, and the camera is farther away than the lamp: shadow rays start
// behind the surface, farther from the lamp than the light sample assumed, and must not hit the
// lamp.
TEST(LocalLightIrradiance, ALampShinesThroughALeaf) {
  Scene scene = Floor();
  Material& leaf = scene.materials[0];
  leaf.bsdf = BsdfKind::kDiffuseTransmission;
  leaf.reflectance = glm::vec3(0), leaf.second_color = glm::vec3(1);
  scene.camera = LookAtCamera({6, -4, -3}, {0, 0, 0}, {0, 1, 0}, 0.01f, false);
  const glm::vec3 radiance(2, 3, 5);
  AddLamp(scene, 0.5f, 0.8f, {0, 2, 0}, radiance);
  for (const bool mis : {true, false}) {
    ExpectIrradiance(scene, radiance * float(4 * CornerIrradiance(0.25, 0.4, 2)), mis);
  }
}

TEST(LocalLightIrradiance, ADistantLightFollowsTheCosine) {
  for (const float degrees : {0.0f, 35.0f, 80.0f, 100.0f}) {
    Scene scene = Floor();
    scene.meshes.pop_back();  // the lid would block the sun
    const float angle = glm::radians(degrees);
    scene.lights = {{.kind = LocalLightKind::kDistant,
                     .emission = {1, 2, 3},
                     .direction = {std::sin(angle), std::cos(angle), 0}}};
    ExpectIrradiance(scene, glm::vec3(1, 2, 3) * std::max(std::cos(angle), 0.0f));
  }
}

TEST(LocalLightIrradiance, ARectangleMatchesItsFormFactor) {
  const glm::vec3 radiance(2, 3, 5);
  for (const bool mis : {true, false}) {
    Scene small = Floor();
    AddLamp(small, 0.5f, 0.8f, {0, 2, 0}, radiance);
    ExpectIrradiance(small, radiance * float(4 * CornerIrradiance(0.25, 0.4, 2)), mis);
    Scene large = Floor();
    AddLamp(large, 12, 8, {6, 1.5f, 4}, radiance);
    ExpectIrradiance(large, radiance * float(CornerIrradiance(12, 8, 1.5)), mis, 4);
    // The lamp is seen from its dark side.
    Scene behind = Floor();
    AddLamp(behind, 1, 1, {0, 2, 0}, radiance, /*upside_down=*/true);
    ExpectIrradiance(behind, glm::vec3(0), mis);
  }
}

// The disk of 512 sides faces the floor.
TEST(LocalLightIrradiance, ADiskMatchesItsFormFactor) {
  constexpr int kSides = 512;
  Scene scene = Floor();
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
  scene.materials[lamp].emission = glm::vec3(4);
  Mesh disk;
  disk.positions.push_back({0, 2, 0});
  for (int i = 0; i < kSides; ++i) {
    const double turn = 2 * kPi * i / kSides;
    disk.positions.push_back({1.5 * std::cos(turn), 2, 1.5 * std::sin(turn)});
    disk.triangles.push_back({0, 1 + i, 1 + (i + 1) % kSides});
  }
  disk.material = lamp;
  scene.meshes.push_back(disk);
  ExpectIrradiance(scene, glm::vec3(float(kPi * 4 * 2.25 / (2.25 + 4))));
}

// The eye sees a lamp itself, via any BSDF sample or mirror, on its emitting side only.
TEST(LocalLightIrradiance, TheCameraSeesTheRadianceOfALamp) {
  for (const bool upside_down : {false, true}) {
    for (const bool over_mirror : {false, true}) {
      for (const Integrator integrator : {Integrator::kDirect, Integrator::kPath}) {
        Scene scene;
        AddLamp(scene, 2, 2, {0, 2, 0}, {3, 4, 5}, upside_down);
        Place(scene, Quad(30), AddMirror(scene, 0.5f), glm::vec3(0));
        const glm::vec3 target = over_mirror ? glm::vec3(0, -2, 0) : glm::vec3(0, 2, 0);
        scene.camera = LookAtCamera({0.1f, 0.7f, 0}, target, {0, 0, 1}, 1, false);
        JobRequest request = SmallRequest(2, 2, 4);
        request.integrator = integrator;
        request.max_depth = 1;
        for (const bool mis : {true, false}) {
          request.options.mis = mis;
          const RenderJob job(scene, request);
          const PictureEstimate picture = EstimateFromEngine(job, 2, 1);
          const double factor = upside_down ? 0 : over_mirror ? 0.5 : 1;
          EXPECT_NEAR(picture.mean[0], 3 * factor, 1e-5);
          EXPECT_NEAR(picture.mean[2], 5 * factor, 1e-5);
        }
      }
    }
  }
}

// Matt, metal, mirror and glass objects under some lights, always with the same camera. All lamps
// exist as surfaces, whether they emit or not.
Scene LitBalls(int lights) {
  Scene scene;
  Place(scene, Quad(6), AddLambert(scene, "floor", {0.6f, 0.55f, 0.5f}), glm::vec3(0));
  Place(scene, Sphere(0.6f, 5), AddMetal(scene, "Au", 0.3f), {-1.2f, 0.6f, 0});
  Place(scene, Sphere(0.5f, 5), AddGlass(scene, 1.5f), {0.1f, 0.5f, 0.9f});
  Place(scene, Sphere(0.5f, 5), AddMirror(scene, 0.9f), {1.3f, 0.5f, -0.3f});
  AddLamp(scene, 1.2f, 0.7f, {0.2f, 2.2f, -0.3f},
          lights & kLamp ? glm::vec3(4, 3, 2) : glm::vec3(0));
  const std::uint32_t ball = AddLambert(scene, "ball", glm::vec3(0.3f));
  scene.materials[ball].emits_on_both_sides = true;
  if (lights & kBall) scene.materials[ball].emission = {0.5f, 2, 1};
  Place(scene, Sphere(0.25f, 2), ball, {1.1f, 0.3f, 1.2f});
  if (lights & kPoint) {
    scene.lights.push_back({.emission = {1, 2, 3}, .position = {-1.6f, 2.1f, 1.1f}});
  }
  AddSlantingLights(scene, lights);
  if (lights & kEnvironment) SetLight(scene, SkyWithSun(32, 16, 3, 0.5));
  scene.camera = LookAtCamera({0.4f, 1.9f, 4.5f}, {0, 0.8f, 0}, {0, 1, 0}, 44, false);
  return scene;
}

JobRequest Request(Integrator integrator, std::uint32_t max_depth) {
  JobRequest request = SmallRequest(24, 18, 32);
  request.integrator = integrator;
  request.max_depth = max_depth;
  request.options.light_samples = integrator == Integrator::kDirect ? 2 : 1;
  return request;
}

void ExpectOracles(const Scene& scene, const JobRequest& request) {
  const RenderJob job(scene, request);
  // Blocks are compared because small lights over glossy metal are too rare and bright for a test
  // of single pixels.
  EXPECT_TRUE(SamePicture(MeanOfBlocks(EstimateFromEngine(job, kRuns, 100), 3),
                          MeanOfBlocks(EstimateFromOracle(scene, job, kRuns), 3), kLevel));
}

class LocalLightPictures : public testing::TestWithParam<int> {};

TEST_P(LocalLightPictures, DirectLightMatchesTheOracle) {
  ExpectOracles(LitBalls(GetParam()), Request(Integrator::kDirect, 4));
}
TEST_P(LocalLightPictures, PathsMatchTheOracle) {
  ExpectOracles(LitBalls(GetParam()), Request(Integrator::kPath, 4));
}
INSTANTIATE_TEST_SUITE_P(Oracle, LocalLightPictures,
                         testing::Values(kLamp, kBall, kPoint | kEnvironment, kSpot, kDistant,
                                         kShaped, kLocal, kLocal | kEnvironment));

TEST(LocalLightEstimators, EveryDepthMatchesTheOracle) {
  const Scene scene = LitBalls(kLamp | kPoint | kEnvironment);
  for (const Integrator integrator : {Integrator::kDirect, Integrator::kPath}) {
    for (const std::uint32_t depth : {0u, 1u, 2u}) {
      SCOPED_TRACE(std::string(ToString(integrator)) + " " + std::to_string(depth));
      ExpectOracles(scene, Request(integrator, depth));
    }
  }
}

// In a matt scene, all three estimates are free of rare, bright samples.
Scene MattRoom(int lights) {
  Scene scene = LitBalls(lights);
  for (Material& material : scene.materials) material.bsdf = BsdfKind::kLambert;
  return scene;
}

// Light samples alone, both kinds of samples, and BSDF samples alone have the same expectation.
TEST(LocalLightEstimators, LightAndBsdfSamplesAgree) {
  // There are no points, which BSDF samples cannot hit, but wide lamps, which they hit often.
  Scene scene = MattRoom(kLamp | kBall | kEnvironment);
  AddLamp(scene, 4, 4, {0, 4, 0}, {1, 2, 1});
  for (const Integrator integrator : {Integrator::kDirect, Integrator::kPath}) {
    JobRequest request = Request(integrator, 3);
    request.strategy = "importance:compensate=0";
    const RenderJob job(scene, request);
    const PictureEstimate both = MeanOfBlocks(EstimateFromEngine(job, kRuns, 1), 3);

    FrameView frame = job.frame();
    frame.options.mis = false;
    const PictureEstimate lights = MeanOfBlocks(EstimateFromEngine(job, frame, kRuns, 1000), 3);
    EXPECT_TRUE(SamePicture(both, lights, kLevel)) << "without MIS";

    // No local light is ever selected.
    const std::vector<std::uint32_t> nothing(frame.local_lights.count + 1);
    frame.options.mis = true;
    frame.local_lights.alone = frame.local_lights.shared = {.first = nothing.data(), .share = 0};
    const PictureEstimate bsdf = MeanOfBlocks(EstimateFromEngine(job, frame, kRuns, 2000), 3);
    EXPECT_TRUE(SamePicture(both, bsdf, kLevel)) << "by BSDF samples alone";
  }
}

PictureEstimate Sum(const PictureEstimate& a, const PictureEstimate& b) {
  PictureEstimate sum = a;
  for (std::size_t i = 0; i < sum.mean.size(); ++i) {
    sum.mean[i] += b.mean[i];
    sum.variance[i] += b.variance[i];
    sum.freedom[i] = std::min(a.freedom[i], b.freedom[i]);
  }
  return sum;
}

// The contribution of a light does not depend on the others.
TEST(LocalLightEstimators, LightsAddUp) {
  for (const Integrator integrator : {Integrator::kDirect, Integrator::kPath}) {
    const auto estimate = [&](int lights, std::uint32_t seed) {
      const RenderJob job(LitBalls(lights), Request(integrator, 3));
      return MeanOfBlocks(EstimateFromEngine(job, kRuns, seed), 3);
    };
    const PictureEstimate environment = estimate(kEnvironment, 1), lamp = estimate(kLamp, 1000),
                          point = estimate(kPoint, 2000);
    EXPECT_TRUE(SamePicture(Sum(environment, lamp), estimate(kEnvironment | kLamp, 3000), kLevel))
        << "environment, lamp";
    EXPECT_TRUE(SamePicture(Sum(environment, point), estimate(kEnvironment | kPoint, 4000), kLevel))
        << "environment, point";
    EXPECT_TRUE(SamePicture(Sum(Sum(environment, point), lamp),
                            estimate(kEnvironment | kPoint | kLamp, 5000), kLevel))
        << "all three";
  }
}

// However the map is sampled, biased or not, local lights contribute the same.
TEST(LocalLightEstimators, NoStrategyChangesLocalLights) {
  const Scene environment = MattRoom(kEnvironment), lamps = MattRoom(kLamp | kPoint),
              all = MattRoom(kEnvironment | kLamp | kPoint);
  JobRequest request = Request(Integrator::kPath, 2);
  request.width = 12, request.height = 9;
  const auto estimate = [&](Scene scene, std::uint32_t seed) {
    scene.portals = PortalsAroundTheOrigin();
    return MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), kRuns, seed), 3);
  };
  const PictureEstimate added = estimate(lamps, 1);
  std::vector<std::string> strategies = {"hybrid:lights=8,inside=1", "hybrid:pick=power",
                                         "penrose:pick=power", "importance:compensate=1"};
  for (const StrategyFactory& factory : Strategies()) strategies.emplace_back(factory.name);
  for (const std::string& strategy : strategies) {
    SCOPED_TRACE(strategy);
    request.strategy = strategy;
    const PictureEstimate map = estimate(environment, 1000);
    EXPECT_TRUE(SamePicture(Sum(map, added), estimate(all, 2000), kLevel));
    // A scene without a map does not use the strategy.
    EXPECT_TRUE(SamePicture(added, estimate(lamps, 3000), kLevel));
  }
}

// Returns a wide lamp above the balls, of which only a corner emits.
Scene PaintedLamp() {
  constexpr int kSide = 8;
  Scene scene = LitBalls(kPoint);
  Image image(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      float* texel = image.Pixel(x, y);
      texel[0] = x + y < 5 ? 1.0f : 0.0f;
      texel[1] = x < 3 ? 0.25f * float(y % 4) : 0.0f;
      texel[2] = 0.03125f;
    }
  }
  scene.images = {image};
  scene.textures = {{.image = 0, .transform = {1, 0.25f, 0, 1, 0.125f, 0}}};
  AddLamp(scene, 3, 3, {0, 2.6f, 0}, {3, 5, 2});
  scene.meshes.back().uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  scene.materials.back().emission_texture = 0;
  return scene;
}

// Both techniques look the texture up; if one used the mean, the pictures would differ.
TEST(LocalLightEstimators, TexturesOfLampsMatchTheOracle) {
  const Scene scene = PaintedLamp();
  ExpectOracles(scene, Request(Integrator::kDirect, 3));
  JobRequest request = Request(Integrator::kPath, 2);
  ExpectOracles(scene, request);
  request.options.mis = false;
  ExpectOracles(scene, request);
}

TEST(LocalLightEstimators, TheOracleDetectsALightOfFivePercentMore) {
  Scene scene = LitBalls(kLamp | kPoint);
  const JobRequest request = Request(Integrator::kDirect, 3);
  const RenderJob job(scene, request);
  const PictureEstimate engine = MeanOfBlocks(EstimateFromEngine(job, kRuns, 100), 3);
  scene.lights[0].emission *= 1.05f;
  EXPECT_FALSE(SamePicture(engine, MeanOfBlocks(EstimateFromOracle(scene, job, kRuns), 3), kLevel));
}

TEST(LocalLightJobs, OnlyASceneWithoutAnyLightIsRefused) {
  EXPECT_NO_THROW(RenderJob(LitBalls(kPoint), Request(Integrator::kPath, 2)));
  EXPECT_NO_THROW(RenderJob(LitBalls(kLamp), Request(Integrator::kPath, 2)));
  EXPECT_THROW(RenderJob(LitBalls(0), Request(Integrator::kPath, 2)), InputError);
}

TEST(LocalLightJobs, BrightLightsFitOntoTheFilm) {
  Scene scene = LitBalls(kLamp | kPoint);
  scene.lights[0].emission = glm::vec3(1e9f);
  const RenderJob job(scene, Request(Integrator::kPath, 3));
  Film film = job.MakeFilm();
  const FrameResult result = RenderFrame(job.frame(), film);
  EXPECT_EQ(result.stats.clamped_samples, 0u);
  EXPECT_EQ(result.stats.invalid_samples, 0u);
}

TEST(LocalLightJobs, SceneHashesDependOnLights) {
  const auto hash = [](const Scene& scene) { return SceneHash(scene); };
  const std::uint64_t dark = hash(LitBalls(0)), lamp = hash(LitBalls(kLamp)),
                      point = hash(LitBalls(kPoint));
  EXPECT_NE(dark, lamp);
  EXPECT_NE(dark, point);
  EXPECT_NE(lamp, point);
}

}  // namespace
}  // namespace skywave
