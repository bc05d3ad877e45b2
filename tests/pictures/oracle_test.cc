// Compares the engine with the oracle: pictures of every BSDF under several lights agree within
// noise.
#include "tests/support/oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "lights/strategies/strategy.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/same_as_oracle.h"
#include "tests/support/screens_scene.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"
#include "wavefront/option_names.h"

namespace skywave {
namespace {

// The scenes show two objects of the tested material on a floor.

std::uint32_t AddConductor(Scene& scene, float alpha, const glm::vec3& eta, const glm::vec3& k) {
  scene.materials.push_back({.name = "metal",
                             .bsdf = BsdfKind::kConductor,
                             .reflectance = glm::vec3(0.9f, 1, 1),
                             .eta = eta,
                             .k = k,
                             .alpha = alpha});
  return std::uint32_t(scene.materials.size() - 1);
}
std::uint32_t AddGold(Scene& scene, float alpha) {
  return AddConductor(scene, alpha, {0.143f, 0.375f, 1.442f}, {3.983f, 2.386f, 1.603f});
}
std::uint32_t AddMetallicMirror(Scene& scene) {
  scene.materials.push_back({.name = "mirror",
                             .bsdf = BsdfKind::kMirror,
                             .reflectance = glm::vec3(0.95f),
                             .eta = {1.657f, 0.880f, 0.521f},
                             .k = {9.224f, 6.270f, 4.837f}});
  return std::uint32_t(scene.materials.size() - 1);
}

struct MaterialCase {
  std::string name;
  std::function<std::uint32_t(Scene&)> add;
};
void PrintTo(const MaterialCase& material, std::ostream* out) { *out << material.name; }
const MaterialCase kLambert = {"Lambert", [](Scene& s) {
                                 return AddLambert(s, "red", {0.8f, 0.3f, 0.2f});
                               }};
const MaterialCase kRoughGold = {"RoughGold", [](Scene& s) { return AddGold(s, 0.5f); }};
const MaterialCase kShinyGold = {"ShinyGold", [](Scene& s) { return AddGold(s, 0.12f); }};
const MaterialCase kSharpGold = {"SharpGold", [](Scene& s) { return AddGold(s, 0.01f); }};
const MaterialCase kWhiteMetal = {
    "WhiteMetal", [](Scene& s) { return AddConductor(s, 0.9f, glm::vec3(0), glm::vec3(0)); }};
std::uint32_t AddMetallicRoughness(Scene& scene, float alpha, float metallic) {
  scene.materials.push_back({.name = "metallic-roughness",
                             .bsdf = BsdfKind::kMetallicRoughness,
                             .reflectance = {0.9f, 0.4f, 0.2f},
                             .alpha = alpha,
                             .metallic = metallic});
  return std::uint32_t(scene.materials.size() - 1);
}
const MaterialCase kVarnish = {"Varnish",
                               [](Scene& s) { return AddMetallicRoughness(s, 0.05f, 0); }};
const MaterialCase kHalfMetal = {"HalfMetal",
                                 [](Scene& s) { return AddMetallicRoughness(s, 0.4f, 0.5f); }};
const MaterialCase kCopper = {"Copper", [](Scene& s) { return AddMetallicRoughness(s, 0.8f, 1); }};
const MaterialCase kMirror = {"Mirror", AddMetallicMirror};
const MaterialCase kGlass = {"Glass", [](Scene& s) { return AddGlass(s, 1.5f); }};

// A coarse smooth ball next to a faceted one makes interpolated normals matter.
Scene TwoBalls(const MaterialCase& material) {
  Scene scene;
  Place(scene, Quad(8), AddLambert(scene, "floor", {0.5f, 0.55f, 0.6f}), glm::vec3(0));
  const std::uint32_t index = material.add(scene);
  Place(scene, Sphere(0.8f, 5), index, {-0.85f, 0.8f, 0});
  Place(scene, Facetted(Sphere(0.8f, 3)), index, {0.95f, 0.8f, 0.2f}, 20);
  scene.camera = LookAtCamera({0.4f, 1.9f, 4.5f}, {0, 0.65f, 0}, {0, 1, 0}, 36, false);
  return scene;
}

class EveryMaterial : public testing::TestWithParam<MaterialCase> {};

TEST_P(EveryMaterial, DirectLightMatchesTheOracleUnderASun) {
  Scene scene = TwoBalls(GetParam());
  SetLight(scene, SkyWithSun(64, 32, 60, 0.15));
  JobRequest request = Request(Integrator::kDirect, 6);
  request.options.light_samples = 3;
  ExpectSame(scene, request);
}

TEST_P(EveryMaterial, PathsMatchTheOracleUnderASun) {
  Scene scene = TwoBalls(GetParam());
  // The lamp is wide because paths from the floor via glass and mirrors hit it by chance only.
  SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
  ExpectSame(scene, Request(Integrator::kPath, 8));
}

TEST_P(EveryMaterial, PathsMatchTheOracleUnderConstantLight) {
  Scene scene = TwoBalls(GetParam());
  SetConstantLight(scene, 0.7f);
  ExpectSame(scene, Request(Integrator::kPath, 12));
}

INSTANTIATE_TEST_SUITE_P(Oracle, EveryMaterial,
                         testing::Values(kLambert, kRoughGold, kShinyGold, kSharpGold, kWhiteMetal,
                                         kVarnish, kHalfMetal, kCopper, kMirror, kGlass),
                         [](const auto& test) { return test.param.name; });

// Returns two tiles with coordinates, which the grain of anisotropic materials follows, in place of
// the balls.
Scene TwoTiles(const Material& material) {
  Scene scene;
  Place(scene, Quad(8), AddLambert(scene, "floor", {0.5f, 0.55f, 0.6f}), glm::vec3(0));
  scene.materials.push_back(material);
  const auto index = std::uint32_t(scene.materials.size() - 1);
  Place(scene, Quad(0.7f), index, {-0.8f, 0.6f, 0.3f}, 35);
  Mesh wall = Quad(0.7f);
  for (glm::vec3& p : wall.positions) p = {p.x, 0.5f * p.z, -p.z};
  wall.normals.clear();
  Place(scene, wall, index, {0.8f, 0.8f, 0}, -20);
  scene.camera = LookAtCamera({0.4f, 1.9f, 4.5f}, {0, 0.65f, 0}, {0, 1, 0}, 36, false);
  return scene;
}

// Returns one of each BSDF that has no picture above, but for measured ones: their value jumps from
// texel to texel.
std::vector<Material> OtherBsdfs() {
  std::vector<Material> all = OneOfEachBsdf();
  using enum BsdfKind;
  for (const Material& material : BeyondTheBuiltinOnes()) all.push_back(material);
  std::erase_if(all, [](const Material& m) {
    return m.bsdf == kLambert || m.bsdf == kConductor || m.bsdf == kMetallicRoughness ||
           m.bsdf == kMirror || m.bsdf == kDielectric || m.bsdf == kMeasured;
  });
  return all;
}

TEST(OraclePictures, OtherBsdfsAgree) {
  std::set<BsdfKind> seen;
  for (Material material : OtherBsdfs()) {
    seen.insert(material.bsdf);
    const BsdfTraits& bsdf = Bsdfs()[std::size_t(material.bsdf)];
    SCOPED_TRACE(std::string(bsdf.name));
    material.coat_alpha = std::max(material.coat_alpha, 0.1f);  // narrower coats flare
    Scene scene = HasTangent(material) ? TwoTiles(material)
                                       : TwoBalls({std::string(bsdf.name), [&](Scene& s) {
                                                     s.materials.push_back(material);
                                                     return std::uint32_t(s.materials.size() - 1);
                                                   }});
    SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
    ExpectSame(scene, Request(Integrator::kPath, 6));
  }
  EXPECT_EQ(seen.size(), kBsdfKinds - 6u);
}

// Glass of two widths, as a tile and as a wall: light passes through both.
TEST(OraclePictures, GlassOfTwoWidthsAgrees) {
  for (const bool compensated : {false, true}) {
    SCOPED_TRACE(compensated);
    Scene scene = TwoTiles({.bsdf = BsdfKind::kRoughDielectric,
                            .reflectance = {1, 0.9f, 0.7f},
                            .alpha = 0.15f,
                            .alpha_across = 0.6f,
                            .energy_compensation = compensated});
    SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
    ExpectSame(scene, Request(Integrator::kPath, 6));
  }
}

TEST(OracleItself, RefusesUnknownFeatures) {
  Scene scene = TwoBalls(kLambert);
  SetConstantLight(scene, 1);
  Material& material = scene.materials.back();
  material.bsdf = BsdfKind::kMeasured;
  EXPECT_THROW(Oracle{scene}, std::logic_error);
  material.bsdf = BsdfKind::kWard;
  EXPECT_THROW(Oracle{scene}, std::logic_error) << "no coordinates, no grain";
  material.bsdf = BsdfKind::kPhong;
  EXPECT_NO_THROW(Oracle{scene});
  material.color_texture = 0;
  EXPECT_THROW(Oracle{scene}, std::logic_error);
  material = {.bsdf = BsdfKind::kDielectric, .absorption = glm::vec3(1)};
  EXPECT_THROW(Oracle{scene}, std::logic_error);
  material = {};
  EXPECT_NO_THROW(Oracle{scene});
  JobRequest request = Request(Integrator::kBdpt, 2);
  const RenderJob job(scene, request);
  EXPECT_THROW(Oracle(scene).Render(job.options()), std::logic_error);
  scene.environments.push_back(scene.environments[0]);
  EXPECT_THROW(Oracle{scene}, std::logic_error);
}

// Images of a few texels, with different wraps, rotations and scales, are applied to every kind of
// parameter.
TEST(OraclePictures, TexturesAgree) {
  Scene scene;
  const std::uint32_t floor = AddLambert(scene, "floor", {0.9f, 0.8f, 0.7f});
  const std::uint32_t paint = AddMetallicRoughness(scene, 0.6f, 0.9f);
  const auto add_image = [&](int width, int height, float step) {
    Image image(width, height);
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
      const float x = float(i) * step;
      image.rgb[i] = 0.1f + 0.9f * (x - std::floor(x));
    }
    scene.images.push_back(Packable(image));
    return std::uint32_t(scene.images.size() - 1);
  };
  const std::uint32_t colors = add_image(5, 3, 0.377f), numbers = add_image(2, 4, 0.591f);
  scene.textures = {{.image = colors,
                     .wrap_u = TextureWrap::kRepeat,
                     .wrap_v = TextureWrap::kMirror,
                     .transform = {2.1f, 0.4f, -0.7f, 3.3f, 0.2f, -0.6f}},
                    {.image = numbers, .wrap_u = TextureWrap::kClamp},
                    {.image = colors, .transform = {1, 0, 0, -1, 0, 1}}};
  scene.materials[floor].color_texture = 0;
  scene.materials[paint].color_texture = 2;
  scene.materials[paint].roughness_texture = 1;
  Place(scene, Quad(3), floor, {0, 0, 0}, 10);
  Place(scene, Quad(1), paint, {0.3f, 0.5f, 0.2f}, 50);
  scene.camera = LookAtCamera({0.4f, 2.9f, 3.5f}, {0, 0.2f, 0}, {0, 1, 0}, 50, false);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
  ExpectSame(scene, Request(Integrator::kPath, 4));
  ExpectSame(scene, Request(Integrator::kDirect, 2));
}

struct StrategyCase {
  std::string strategy;
  bool mis;
};
// Returns all unbiased strategies, with their defaults and with some parameters that change their
// behaviour.
std::vector<StrategyCase> StrategyCases() {
  std::vector<StrategyCase> cases = {{"importance:compensate=1", true},
                                     {"importance", false},
                                     {"uniform", false},
                                     {"cosine", false},
                                     {"portal:texels=64", false},
                                     {"portal:texels=64,share=0", true},
                                     {"hybrid:lights=8,inside=1", true},
                                     {"hybrid:lights=8,inside=1", false}};
  const EnvironmentMap map = {.latlong = AdversarialMap("Ramp"),
                              .map_from_world = Orientations()[0].map_from_world,
                              .portals = PortalsAroundTheOrigin()};
  for (const StrategyFactory& factory : Strategies()) {
    const std::string name(factory.name);
    if (MakeStrategy(name, map)->unbiased()) cases.push_back({name, true});
  }
  return cases;
}

// Renders `scene` with every strategy and compares each picture with one picture of the oracle.
void ExpectAllStrategiesSame(Scene scene, const JobRequest& request, int block,
                             const std::function<bool(const StrategyCase&)>& wanted) {
  scene.portals = PortalsAroundTheOrigin();  // light comes in elsewhere too
  const PictureEstimate oracle =
      MeanOfBlocks(EstimateFromOracle(scene, RenderJob(scene, request), kRuns), block);
  static const std::vector<StrategyCase> strategies = StrategyCases();
  for (const StrategyCase& strategy : strategies) {
    if (!wanted(strategy)) continue;
    SCOPED_TRACE(strategy.strategy + (strategy.mis ? " with MIS" : " without MIS"));
    JobRequest by_strategy = request;
    by_strategy.strategy = strategy.strategy;
    by_strategy.options.mis = strategy.mis;
    const RenderJob job(scene, by_strategy);
    EXPECT_TRUE(
        SamePicture(MeanOfBlocks(EstimateFromEngine(job, kRuns, 100), block), oracle, kLevel));
  }
}
// Returns true for strategies whose estimates of a small sun are normal enough for a test of means:
// BSDF sampling alone hits it only a few times.
bool FindsSuns(const StrategyCase& strategy) { return strategy.strategy != "bsdf"; }

TEST(EveryStrategy, BsdfSamplingAloneMatchesTheOracle) {
  Scene scene = TwoBalls(kLambert);
  SetLight(scene, Packable(AdversarialMap("Ramp")));
  ExpectAllStrategiesSame(scene, Request(Integrator::kPath, 5), 1,
                          [](const StrategyCase& strategy) { return strategy.strategy == "bsdf"; });
}

TEST(EveryStrategy, PathsOverAMetalWithMisMatchTheOracle) {
  Scene scene = TwoBalls(kRoughGold);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
  // Without it, the grazing lobes of metals give rare, bright samples that defeat a test of means.
  ExpectAllStrategiesSame(scene, Request(Integrator::kPath, 5), 1,
                          [](const StrategyCase& s) { return s.mis && FindsSuns(s); });
}

TEST(EveryStrategy, PathsMatchTheOracle) {
  Scene scene = TwoBalls(kLambert);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
  ExpectAllStrategiesSame(scene, Request(Integrator::kPath, 5), 1, FindsSuns);
}

TEST(EveryStrategy, DirectLightMatchesTheOracle) {
  Scene scene = TwoBalls(kLambert);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
  JobRequest request = Request(Integrator::kDirect, 3);
  request.options.light_samples = 4;
  ExpectAllStrategiesSame(scene, request, 1, FindsSuns);
}

// On maps that challenge samplers, where the light is hard to find, blocks of the picture are
// compared.
class EveryStrategyOnMap : public testing::TestWithParam<std::string> {};

TEST_P(EveryStrategyOnMap, MatchesTheOracle) {
  Scene scene = TwoBalls(kLambert);
  SetLight(scene, Packable(AdversarialMap(GetParam())), EnvironmentFrame('y', false, 33));
  JobRequest request = Request(Integrator::kPath, 2);
  request.width = 12, request.height = 9;
  request.samples_per_pixel = 128;
  ExpectAllStrategiesSame(scene, request, 12, FindsSuns);
}

INSTANTIATE_TEST_SUITE_P(Oracle, EveryStrategyOnMap,
                         testing::Values("OneTexel", "Seam", "NorthPole", "SouthPole", "Ramp",
                                         "ThreeByTwo", "OneByOne", "Black"),
                         [](const auto& test) { return test.param; });

class EveryOrientation : public testing::TestWithParam<NamedOrientation> {};

TEST_P(EveryOrientation, PathsMatchTheOracle) {
  Scene scene = TwoBalls(kShinyGold);
  const std::array<float, 9>& m = GetParam().map_from_world;
  SetLight(scene, SkyWithSun(48, 24, 60, 0.15),
           glm::mat3(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]));
  ExpectSame(scene, Request(Integrator::kPath, 4));
}

INSTANTIATE_TEST_SUITE_P(Oracle, EveryOrientation,
                         testing::ValuesIn(Orientations().begin(), Orientations().end()),
                         [](const auto& test) { return test.param.name; });

TEST(OraclePictures, EveryDepthOfBothIntegratorsAgrees) {
  // Mirror, glass and matt surfaces together show that depth is counted in the same way.
  Scene scene = TwoBalls(kGlass);
  Place(scene, Sphere(0.3f, 6), AddMetallicMirror(scene), {0.1f, 0.3f, 1.3f});
  SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
  for (const Integrator integrator : {Integrator::kDirect, Integrator::kPath}) {
    for (const std::uint32_t depth : {0u, 1u, 2u, 3u}) {
      SCOPED_TRACE(std::string(ToString(integrator)) + " " + std::to_string(depth));
      ExpectSame(scene, Request(integrator, depth));
    }
  }
}

// The normals of open sheets lean by up to 60 degrees; nothing behind them hides leaks.
TEST(OraclePictures, NormalsThatLeanFarAgree) {
  for (const MaterialCase& material : {kLambert, kRoughGold, kMirror, kGlass}) {
    SCOPED_TRACE(material.name);
    Scene scene;
    const std::uint32_t index = material.add(scene);
    Mesh sheet = Quad(1.2f);
    for (std::size_t i = 0; i < sheet.normals.size(); ++i) {
      const glm::vec3& p = sheet.positions[i];
      sheet.normals[i] = glm::normalize(glm::vec3(1.4f * p.x, 1, -0.9f * p.z));
    }
    Place(scene, sheet, index, glm::vec3(0));
    SetLight(scene, SkyWithSun(64, 32, 8, 0.5), EnvironmentFrame('z', false, 70));
    scene.camera = LookAtCamera({0.4f, 0.9f, 3}, {0, 0, 0}, {0, 1, 0}, 50, false);
    ExpectSame(scene, Request(Integrator::kPath, 4));
    ExpectSame(scene, Request(Integrator::kDirect, 4));
  }
}

TEST(OraclePictures, EveryFilterAgrees) {
  Scene scene = TwoBalls(kLambert);
  SetLight(scene, SkyWithSun(64, 32, 20, 0.3));
  for (const PixelFilter filter : {PixelFilter::kBox, PixelFilter::kTriangle,
                                   PixelFilter::kGaussian, PixelFilter::kBlackmanHarris}) {
    SCOPED_TRACE(ToString(filter));
    JobRequest request = Request(Integrator::kDirect, 1);
    request.filter = filter;
    ExpectSame(scene, request);
  }
}

TEST(OraclePictures, EveryCameraAgrees) {
  for (const CameraKind kind : kCameraKinds) {
    for (const float lens : {0.0f, 0.15f}) {
      if (lens > 0 && !HasPlaneFilm(kind)) continue;  // these have none
      SCOPED_TRACE(std::string(ToString(kind)) + (lens > 0 ? " with a lens" : ""));
      Scene scene = TwoBalls(kShinyGold);
      SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
      scene.camera = LookAtCamera({0.4f, 1.9f, 2.5f}, {0.2f, 0.65f, 0}, {0, 1, 0}, 60, false);
      scene.camera->kind = kind;
      scene.camera->lens_radius = lens;
      scene.camera->focal_distance = 1.7f;
      if (kind == CameraKind::kFisheye) scene.camera->fov_degrees = 200;
      if (kind == CameraKind::kOrthographic) scene.camera->window = {-1.5f, 2, -1, 1.2f};
      JobRequest request = Request(Integrator::kPath, 3);
      if (kind == CameraKind::kEqualArea) request.height = request.width;
      ExpectSame(scene, request);
    }
  }
}

TEST(OraclePictures, CameraOfALeftHandedWorldAgrees) {
  Scene scene = TwoBalls(kLambert);
  SetLight(scene, SkyWithSun(64, 32, 20, 0.3));
  scene.camera = LookAtCamera({2.5f, 2.2f, 3.5f}, {0, 0.5f, 0}, {0.2f, 1, 0}, 50, true);
  JobRequest request = Request(Integrator::kDirect, 2);
  request.width = 20, request.height = 31;  // portrait: the field of view is that of the width
  ExpectSame(scene, request);
}

TEST(OracleItself, UniformAndImportanceLightSamplesAgree) {
  Scene scene = TwoBalls(kShinyGold);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
  const RenderJob job(scene, Request(Integrator::kPath, 3));
  RenderOptions options = job.options();
  options.samples_per_pixel = 16 * kRuns;
  const OraclePicture uniform = Oracle(scene, OracleLights::kUniform).Render(options);
  options.seed = 1;
  const OraclePicture importance = Oracle(scene).Render(options);
  EXPECT_TRUE(SamePicture(EstimateFrom(uniform, options.samples_per_pixel),
                          EstimateFrom(importance, options.samples_per_pixel), kLevel));
}

TEST(OracleItself, ALambertPlaneUnderConstantLightShowsItsAlbedo) {
  Scene scene;
  Place(scene, Quad(50), AddLambert(scene, "floor", {0.2f, 0.5f, 0.9f}), glm::vec3(0));
  scene.camera = LookAtCamera({0, 2, 0}, {0, 0, 0}, {0, 0, 1}, 40, false);
  SetConstantLight(scene, 2);
  const RenderJob job(scene, Request(Integrator::kPath, 3));
  RenderOptions options = job.options();
  options.samples_per_pixel *= kRuns;
  const PictureEstimate whole =
      MeanOfBlocks(EstimateFrom(Oracle(scene).Render(options), options.samples_per_pixel), kWidth);
  const double albedo[3] = {0.2, 0.5, 0.9};
  for (int c = 0; c < 3; ++c) {
    EXPECT_TRUE(AgreesWith(whole.mean[c], std::sqrt(whole.variance[c]), 2 * albedo[c], 1e-4, 1e-4));
  }
}

// A difference invisible to the eye is detected, so the comparison can fail.
TEST(OracleItself, ADifferenceOfThreePercentIsFound) {
  Scene scene = TwoBalls(kLambert);
  SetLight(scene, SkyWithSun(64, 32, 8, 0.4));
  const RenderJob job(scene, Request(Integrator::kPath, 5));
  const PictureEstimate engine = EstimateFromEngine(job, kRuns, 100);
  scene.materials[1].reflectance *= 0.97f;
  EXPECT_FALSE(SamePicture(engine, EstimateFromOracle(scene, job, kRuns), kLevel));
}

}  // namespace
}  // namespace skywave
