// Compares light tracing with closed forms, and with path tracing where both can see the light.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "base/error.h"
#include "scene/shapes/mesh.h"
#include "tests/support/light_test_maps.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "wavefront/option_names.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kRuns = 12;
// This many comparisons of pictures share the level of the test program.
const double kLevel = SidakLevel(40);

// Adds a rectangle at `centre` that emits downwards.
void AddLamp(Scene& scene, float side, const glm::vec3& centre, const glm::vec3& radiance,
             bool both_sides = false) {
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
  scene.materials[lamp].emission = radiance;
  scene.materials[lamp].emits_on_both_sides = both_sides;
  Mesh mesh = Quad(side / 2);
  FlipOrientation(mesh);
  Place(scene, mesh, lamp, centre);
}

std::uint32_t AddGloss(Scene& scene, float alpha) {
  scene.materials.push_back({.name = "gloss",
                             .bsdf = BsdfKind::kMetallicRoughness,
                             .reflectance = {0.9f, 0.4f, 0.2f},
                             .alpha = alpha,
                             .metallic = 0.3f});
  return std::uint32_t(scene.materials.size() - 1);
}

std::uint32_t AddThinPane(Scene& scene) {
  const std::uint32_t pane = AddGlass(scene, 1.5f);
  scene.materials[pane].bsdf = BsdfKind::kThinDielectric;
  return pane;
}

// Returns a floor, a faceted ball, a glossy ball with smooth normals, and a translucent leaf.
Scene Things() {
  Scene scene;
  Place(scene, Quad(4), AddLambert(scene, "floor", {0.5f, 0.55f, 0.6f}), glm::vec3(0));
  Place(scene, Facetted(Sphere(0.8f, 3)), AddLambert(scene, "red", {0.8f, 0.3f, 0.2f}),
        {-0.85f, 0.8f, 0}, 20);
  // The mesh is fine because paths from the two ends differ where smooth normals face away from the
  // eye.
  Place(scene, Sphere(0.7f, 40), AddGloss(scene, 0.35f), {0.95f, 0.7f, 0.2f});
  scene.materials.push_back(
      {.name = "leaf", .bsdf = BsdfKind::kDiffuseTransmission, .reflectance = {0.2f, 0.4f, 0.1f}});
  scene.materials.back().second_color = {0.3f, 0.5f, 0.2f};
  Place(scene, Quad(0.6f), std::uint32_t(scene.materials.size() - 1), {0, 1.3f, 1});
  scene.camera = LookAtCamera({0.4f, 2.4f, 4.5f}, {0, 0.65f, 0}, {0, 1, 0}, 40, false);
  return scene;
}

void AddLocalLights(Scene& scene) {
  AddLamp(scene, 1.2f, {0.5f, 3, 0.5f}, {6, 5, 4});
  AddLamp(scene, 0.5f, {-1.8f, 0.4f, 1}, {2, 3, 5}, /*both_sides=*/true);
  scene.lights = {{.emission = {2, 3, 1}, .position = {-1.5f, 2, 2}},
                  {.kind = LocalLightKind::kSpot,
                   .emission = {20, 15, 10},
                   .position = {2, 3, 2},
                   .direction = glm::normalize(glm::vec3(-2, -2.5f, -1.5f)),
                   .cos_full = 0.96f,
                   .cos_dark = 0.85f},
                  {.kind = LocalLightKind::kDistant,
                   .emission = {0.3f, 0.5f, 0.4f},
                   .direction = glm::normalize(glm::vec3(1, 2, 1.5f))}};
}

JobRequest Request(std::uint32_t max_depth, std::uint32_t samples = 48) {
  JobRequest request = SmallRequest(32, 24, samples);
  request.max_depth = max_depth;
  return request;
}

PictureEstimate Estimate(const Scene& scene, JobRequest request, Integrator integrator) {
  request.integrator = integrator;
  const RenderJob job(scene, request);
  return EstimateFromEngine(job, kRuns, integrator == Integrator::kLight ? 100 : 900);
}

void ExpectSame(const Scene& scene, const JobRequest& request) {
  EXPECT_TRUE(SamePicture(Estimate(scene, request, Integrator::kLight),
                          Estimate(scene, request, Integrator::kPath), kLevel));
}

TEST(LightTracing, MatchesPathTracingUnderAMap) {
  Scene scene = Things();
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  for (const std::uint32_t depth : {1u, 2u, 6u}) {
    SCOPED_TRACE(depth);
    ExpectSame(scene, Request(depth));
  }
}

TEST(LightTracing, MatchesPathTracingUnderLamps) {
  Scene scene = Things();
  AddLocalLights(scene);
  for (const std::uint32_t depth : {1u, 5u}) {
    SCOPED_TRACE(depth);
    ExpectSame(scene, Request(depth));
  }
}

TEST(LightTracing, MatchesPathTracingUnderShapedLights) {
  Scene scene = Things();
  scene.lights = ShapedLights(scene);
  ExpectSame(scene, Request(4));
}

TEST(LightTracing, MatchesPathTracingUnderMapAndLamps) {
  Scene scene = Things();
  AddLocalLights(scene);
  SetLight(scene, SkyWithSun(64, 32, 20, 0.2));
  ExpectSame(scene, Request(4));
}

TEST(LightTracing, MatchesPathTracingThroughALens) {
  Scene scene = Things();
  AddLocalLights(scene);
  scene.camera->lens_radius = 0.15f;
  scene.camera->focal_distance = 4;
  ExpectSame(scene, Request(3));
}

// Far out of focus and under a filter of several pixels the shape of a spot shows whether the point
// of the lens and the pixel are chosen independently.
TEST(LightTracing, MatchesPathTracingOutOfFocusUnderAWideFilter) {
  Scene scene;
  Place(scene, Quad(0.25f), AddLambert(scene, "spot", glm::vec3(0.9f)), {0.1f, 0, -0.1f});
  AddLamp(scene, 0.6f, {0.8f, 1.5f, 0.6f}, {8, 7, 6});
  scene.camera = LookAtCamera({0, 4, 0.5f}, {0, 0, 0}, {0, 1, 0}, 40, false);
  scene.camera->lens_radius = 0.3f;
  scene.camera->focal_distance = 2;
  JobRequest request = Request(1, 192);
  request.filter = PixelFilter::kBox;
  request.options.filter_radius = 2.5f;
  ExpectSame(scene, request);
}

TEST(LightTracing, MatchesPathTracingInEveryCameraAndPartOfAFilm) {
  Scene scene = Things();
  AddLamp(scene, 1.2f, {0.5f, 3, 0.5f}, {6, 5, 4});
  SetConstantLight(scene, 0.3f);
  for (const CameraKind kind : kCameraKinds) {
    SCOPED_TRACE(ToString(kind));
    JobRequest request = Request(2, 24);
    request.camera.kind = kind;
    ExpectSame(scene, request);
  }
  JobRequest part = Request(2, 48);
  part.crop = CropWindow{9, 7, 12, 9};
  part.filter = PixelFilter::kGaussian;
  ExpectSame(scene, part);
}

// Glass focuses light on the floor; the ball itself is outside the picture.
TEST(LightTracing, MatchesPathTracingUnderGlass) {
  Scene scene;
  Place(scene, Quad(4), AddLambert(scene, "floor", glm::vec3(0.7f)), glm::vec3(0));
  Place(scene, Facetted(Sphere(0.7f, 12)), AddGlass(scene, 1.5f), {0, 1.6f, 0});
  scene.camera = LookAtCamera({0, 0.8f, 2.4f}, {0, 0, 0.1f}, {0, 1, 0}, 28, false);
  // The lamp is large because paths hit it by chance only.
  AddLamp(scene, 1.6f, {0.3f, 4, 0.2f}, {8, 8, 6});
  const JobRequest request = Request(6, 192);
  ExpectSame(scene, request);
  // Rough glass is tested too: its value must lose the squared index.
  scene.materials[1].bsdf = BsdfKind::kRoughDielectric;
  scene.materials[1].alpha = 0.2f;
  ExpectSame(scene, request);
}

// Light paths start in texels of the map, so camera paths that reach it over mirrors and glass have
// to see texels, too. All the light of the floor comes through panes.
TEST(LightTracing, MatchesPathTracingUnderACoarseMapBehindGlass) {
  Scene scene;
  Place(scene, Quad(1), AddLambert(scene, "floor", glm::vec3(0.7f)), glm::vec3(0));
  Place(scene, Facetted(RoundedBox(glm::vec3(1.2f), 1e-3f, 1)), AddThinPane(scene), glm::vec3(0));
  SetLight(scene, test::NoiseMap(6, 3, 7));
  scene.camera = LookAtCamera({0, 0.9f, 0.2f}, {0, 0, 0}, {0, 1, 0}, 50, false);
  const JobRequest request = Request(6, 96);
  JobRequest split = request;
  split.options.bsdf_samples = 4;
  const PictureEstimate light = Estimate(scene, request, Integrator::kLight);
  EXPECT_TRUE(SamePicture(light, Estimate(scene, request, Integrator::kPath), kLevel));
  EXPECT_TRUE(SamePicture(light, Estimate(scene, split, Integrator::kPath), kLevel));
}

// No light sample goes through glass, so what directional lights stand for is seen behind it. Of a
// map of one colour all strategies make the same picture.
TEST(LightTracing, LightBehindGlassIsNotLeftToDirectionalLights) {
  Scene scene;
  Place(scene, Quad(1), AddLambert(scene, "floor", glm::vec3(0.7f)), glm::vec3(0));
  Place(scene, Facetted(RoundedBox(glm::vec3(1.2f), 1e-3f, 1)), AddThinPane(scene), glm::vec3(0));
  SetConstantLight(scene, 0.5f);
  scene.camera = LookAtCamera({0, 0.9f, 0.2f}, {0, 0, 0}, {0, 1, 0}, 50, false);
  JobRequest request = Request(6, 96);
  const PictureEstimate light = Estimate(scene, request, Integrator::kLight);
  for (const char* const strategy : {"median-cut", "presampled:mode=fixed", "hybrid:strata=p"}) {
    SCOPED_TRACE(strategy);
    request.strategy = strategy;
    EXPECT_TRUE(SamePicture(light, Estimate(scene, request, Integrator::kPath), kLevel));
  }
}

// The floor's shading normals lean by 20 degrees, and a ball hangs above it, low enough that no
// path runs along the floor: Veach's factor matters where flux is connected and where it is
// scattered.
TEST(LightTracing, MatchesPathTracingOnBentNormals) {
  for (const float alpha : {0.0f, 0.4f}) {
    Scene scene;
    Mesh floor = Quad(1);
    floor.normals.assign(floor.positions.size(), glm::normalize(glm::vec3(0.364f, 1, 0)));
    const std::uint32_t material =
        alpha > 0 ? AddGloss(scene, alpha) : AddLambert(scene, "floor", glm::vec3(0.9f));
    Place(scene, floor, material, glm::vec3(0));
    Place(scene, Facetted(Sphere(0.5f, 4)), AddLambert(scene, "ball", glm::vec3(0.9f)),
          {0, 1.6f, 0});
    AddLamp(scene, 0.4f, {-0.6f, 3, 0.5f}, {40, 30, 20});
    scene.camera = LookAtCamera({1.5f, 3, 3}, {0, 0.7f, 0}, {0, 1, 0}, 45, false);
    ExpectSame(scene, Request(4, 96));
  }
}

// Directional lights replace a map; both integrators use the same directions.
TEST(LightTracing, MatchesPathTracingUnderDirectionalLights) {
  Scene scene = Things();
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  for (const char* const strategy : {"median-cut:pick=power", "presampled", "hybrid:pick=power"}) {
    SCOPED_TRACE(strategy);
    JobRequest request = Request(3);
    request.strategy = strategy;
    ExpectSame(scene, request);
  }
}

TEST(LightTracing, MatchesPathTracingThroughAlpha) {
  Scene scene = Things();
  scene.materials[1].opacity = 0.6f;
  AddLamp(scene, 1.2f, {0.5f, 3, 0.5f}, {6, 5, 4});
  scene.materials.back().opacity = 0.5f;
  ExpectSame(scene, Request(3));
}

double MeanOf(const PictureEstimate& picture) {
  return MeanOfBlocks(picture, std::max(picture.width, picture.height)).mean[1];
}
double ErrorOf(const PictureEstimate& picture) {
  return std::sqrt(MeanOfBlocks(picture, std::max(picture.width, picture.height)).variance[1]);
}

// A plane sees only the environment: a constant one, and a single sun.
TEST(LightTracing, APlaneHasTheExactRadiance) {
  Scene scene;
  Place(scene, Quad(2), AddLambert(scene, "plane", glm::vec3(0.8f)), glm::vec3(0));
  scene.camera = LookAtCamera({0.3f, 2, 0.5f}, {0, 0, 0}, {0, 1, 0}, 20, false);
  Scene sun = scene;
  SetConstantLight(scene, 0.7f);
  const PictureEstimate constant = Estimate(scene, Request(4), Integrator::kLight);
  EXPECT_TRUE(AgreesWith(MeanOf(constant), ErrorOf(constant), 0.8 * 0.7, kLevel, 1e-5));

  const glm::vec3 to = glm::normalize(glm::vec3(1, 2, -0.5f));
  sun.lights = {{.kind = LocalLightKind::kDistant, .emission = glm::vec3(3), .direction = to}};
  const PictureEstimate lit = Estimate(sun, Request(4), Integrator::kLight);
  EXPECT_TRUE(AgreesWith(MeanOf(lit), ErrorOf(lit), 0.8 / kPi * 3 * to.y, kLevel, 1e-5));
}

// The sphere is white and convex, so it vanishes in a furnace; under a sun its picture is
// Lambert's.
TEST(LightTracing, AWhiteSphereVanishesInAFurnaceAndIsLambertianUnderASun) {
  Scene scene;
  Place(scene, Sphere(1, 60), AddLambert(scene, "white", glm::vec3(1)), glm::vec3(0));
  scene.camera = LookAtCamera({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 30, false);
  Scene sun = scene;
  SetConstantLight(scene, 1);
  const PictureEstimate furnace = Estimate(scene, Request(3), Integrator::kLight);
  PictureEstimate white = furnace;
  std::fill(white.mean.begin(), white.mean.end(), 1.0);
  std::fill(white.variance.begin(), white.variance.end(), 0.0);
  // At this resolution, the sphere's smooth normals and its silhouette deviate by up to 0.01.
  EXPECT_TRUE(SamePicture(furnace, white, kLevel, 0.01));

  const glm::vec3 to = glm::normalize(glm::vec3(1, 1, 1));
  sun.lights = {{.kind = LocalLightKind::kDistant, .emission = glm::vec3(2), .direction = to}};
  sun.camera->fov_degrees = 6;  // its middle
  const PictureEstimate lit = Estimate(sun, Request(1), Integrator::kLight);
  PictureEstimate exact = lit;
  const double half = std::tan(3 * kPi / 180);
  for (int y = 0; y < lit.height; ++y) {
    for (int x = 0; x < lit.width; ++x) {
      const double right = (x + 0.5 - 16) / 12 * half, up = (12 - y - 0.5) / 12 * half;
      // This is the nearer intersection of the ray (0, 0, 5) + s (right, up, -1).
      const double a = 1 + right * right + up * up;
      const double s = (5 - std::sqrt(25 - 24 * a)) / a;
      const double cosine = (s * right + s * up + 5 - s) / std::sqrt(3.0);
      for (int c = 0; c < 3; ++c) {
        const auto i = std::size_t((y * lit.width + x) * 3 + c);
        exact.mean[i] = 2 / kPi * cosine, exact.variance[i] = 0;
      }
    }
  }
  EXPECT_TRUE(SamePicture(lit, exact, kLevel, 0.02));
}

// Light paths go on with normals that face their light, and camera paths with those that face the
// eye, so silhouettes of coarse meshes differ by some tenths of a percent, as
// docs/design/bidirectional.md says.
TEST(LightTracing, NearlyMatchesPathTracingAtSmoothSilhouettes) {
  Scene scene;
  // Most light paths of a small scene meet what the camera sees.
  Place(scene, Quad(1.1f), AddLambert(scene, "floor", glm::vec3(0.6f)), glm::vec3(0));
  Place(scene, Sphere(0.8f, 3), AddLambert(scene, "ball", glm::vec3(0.8f)), {0, 0.8f, 0});
  AddLamp(scene, 1, {0.7f, 2.2f, 0.5f}, {6, 6, 6});
  scene.camera = LookAtCamera({0.3f, 2.6f, 2.6f}, {0, 0.4f, 0}, {0, 1, 0}, 32, false);
  // Runs are compared as a whole: the points of light paths are spread over the film together.
  constexpr std::uint32_t kSamples[] = {256, 1024};
  Moments means[2];
  for (const bool light : {false, true}) {
    JobRequest request = Request(4, kSamples[light]);
    request.integrator = light ? Integrator::kLight : Integrator::kPath;
    const RenderJob job(scene, request);
    for (std::uint32_t run = 0; run < kRuns; ++run) {
      FrameView frame = job.frame();
      frame.options.seed = 100 + run;
      Film film = job.MakeFilm();
      RenderFrame(frame, film);
      double sum = 0;
      for (const float value : film.Resolve(kSamples[light]).rgb) sum += double(value);
      means[light].Add(sum);
    }
  }
  const double difference = means[1].mean() / means[0].mean() - 1;
  const double error =
      std::hypot(means[0].standard_error(), means[1].standard_error()) / means[0].mean();
  std::printf("light over path: %.5f +- %.5f\n", difference, error);
  EXPECT_LT(error, 0.001);
  EXPECT_LT(std::abs(difference), 0.005);
}

void ExpectRefused(const Scene& scene, const JobRequest& request, const std::string& part) {
  try {
    const RenderJob job(scene, request);
    ADD_FAILURE() << "not refused: " << part;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(LightTracing, RefusesStrategiesThatCannotEmit) {
  Scene scene = Things();
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  JobRequest request = Request(3);
  request.integrator = Integrator::kLight;
  for (const char* const strategy :
       {"cosine", "bsdf", "product", "ris", "median-cut", "hybrid", "importance:compensate=1"}) {
    request.strategy = strategy;
    ExpectRefused(scene, request, "no light path can start");
  }
  // If the map is black, the strategy is never used.
  Scene lamps = Things();
  AddLocalLights(lamps);
  EXPECT_NO_THROW(RenderJob(lamps, request));
  request.strategy = "importance";
  EXPECT_NO_THROW(RenderJob(scene, request));
  request.options.aovs = *ParseAovs("normal,variance");
  ExpectRefused(scene, request, "variance, halves, direct and indirect are of samples of a pixel");
  request.options.aovs = *ParseAovs("normal,depth");
  EXPECT_NO_THROW(RenderJob(scene, request));
  request.options.aovs = 0;
  SetConstantLight(scene, 0);
  ExpectRefused(scene, request, "nothing shines");
  Scene flat = Things();
  flat.meshes.resize(1);
  for (glm::vec3& p : flat.meshes[0].positions) p = glm::vec3(1);
  SetConstantLight(flat, 1);
  flat.camera = scene.camera;
  ExpectRefused(flat, request, "no place for light paths");
}

// First hits come from the camera rays, as in path tracing.
TEST(LightTracing, KeepsTheLayersOfFirstHits) {
  Scene scene = Things();
  SetConstantLight(scene, 1);
  JobRequest request = Request(2, 4);
  request.options.aovs = *ParseAovs("normal,depth,object-id,coverage");
  std::vector<NamedChannel> layers[2];
  for (const Integrator integrator : {Integrator::kPath, Integrator::kLight}) {
    request.integrator = integrator;
    const RenderJob job(scene, request);
    Film film = job.MakeFilm();
    RenderFrame(job.frame(), film);
    layers[integrator == Integrator::kLight] = film.ResolveAovs(4);
  }
  ASSERT_EQ(layers[0].size(), layers[1].size());
  for (std::size_t i = 0; i < layers[0].size(); ++i) {
    EXPECT_EQ(layers[0][i].values, layers[1][i].values) << layers[0][i].name;
  }
}

}  // namespace
}  // namespace skywave
