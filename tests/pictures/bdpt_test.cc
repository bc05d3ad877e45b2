// Compares bidirectional paths with paths from the camera: pictures have the same expectation for
// all lights, materials and cameras.
#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/shapes/mesh.h"
#include "tests/support/matt_room.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/shining_cave.h"
#include "tests/support/statistics.h"
#include "wavefront/option_names.h"
#include "wavefront/render.h"
#include "wavefront/stages/bidirectional.h"

namespace skywave {
namespace {

constexpr int kRuns = 12;
// This many comparisons of pictures share the level of the test program.
const double kLevel = SidakLevel(70);

JobRequest Request(Integrator integrator, std::uint32_t max_depth) {
  JobRequest request = SmallRequest(24, 18, 32);
  request.integrator = integrator;
  request.max_depth = max_depth;
  return request;
}

// The oracle follows paths from the camera by code of its own.
TEST(Bdpt, PicturesMatchTheOracle) {
  for (const BsdfKind kind : {BsdfKind::kLambert, BsdfKind::kConductor, BsdfKind::kDielectric}) {
    const Scene scene = MattRoom(Of(kind), kEnvironment | kLamp);
    const RenderJob bdpt(scene, Request(Integrator::kBdpt, 4));
    const RenderJob paths(scene, Request(Integrator::kPath, 4));
    EXPECT_TRUE(SamePicture(MeanOfBlocks(EstimateFromEngine(bdpt, kRuns, 0), 3),
                            MeanOfBlocks(EstimateFromOracle(scene, paths, kRuns), 3), kLevel))
        << Bsdfs()[int(kind)].name;
  }
}

TEST(Bdpt, CaveIsAsBrightAsItsSeries) {
  const PictureEstimate picture =
      EstimateFromEngine(RenderJob(ShiningCave(), Request(Integrator::kBdpt, 5)), kRuns, 0);
  double sum[3] = {};
  for (std::size_t i = 0; i < picture.mean.size(); ++i) sum[i % 3] += picture.mean[i];
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(3 * sum[c] / double(picture.mean.size()) / CaveRadiance(c, 5), 1, 0.01) << c;
  }
}

// Light paths start by other strategies than the default, and by directional lights.
TEST(Bdpt, OtherStrategiesMatchPathTracing) {
  for (const char* const strategy :
       {"alias", "uniform", "presampled", "median-cut:pick=power", "hybrid:pick=power"}) {
    JobRequest request = Request(Integrator::kBdpt, 4);
    request.strategy = strategy;
    EXPECT_TRUE(
        SameAsPaths(MattRoom(Of(BsdfKind::kLambert), kEnvironment | kLamp), request, kRuns, kLevel))
        << strategy;
  }
}

class BdptLights : public testing::TestWithParam<int> {};

TEST_P(BdptLights, PicturesMatchPathTracing) {
  EXPECT_TRUE(SameAsPaths(MattRoom(Of(BsdfKind::kLambert), GetParam()),
                          Request(Integrator::kBdpt, 4), kRuns, kLevel));
}
INSTANTIATE_TEST_SUITE_P(Bdpt, BdptLights,
                         testing::Values(kEnvironment, kLamp, kBall, kPoint, kSpot, kDistant,
                                         kEnvironment | kLamp, kShaped,
                                         kEnvironment | kLocal | kShaped),
                         [](const auto& test) { return "Lights" + std::to_string(test.param); });

struct BsdfCase {
  BsdfKind kind;
  float alpha = 0.3f;
};
void PrintTo(const BsdfCase& test, std::ostream* out) { *out << Bsdfs()[int(test.kind)].name; }
class BdptBsdfs : public testing::TestWithParam<BsdfCase> {};

TEST_P(BdptBsdfs, PicturesMatchPathTracing) {
  const BsdfCase& test = GetParam();
  EXPECT_TRUE(SameAsPaths(MattRoom(Of(test.kind, test.alpha), kEnvironment | kLamp),
                          Request(Integrator::kBdpt, 5), kRuns, kLevel));
}
INSTANTIATE_TEST_SUITE_P(
    Bdpt, BdptBsdfs,
    testing::Values(BsdfCase{BsdfKind::kConductor, 0.15f}, BsdfCase{BsdfKind::kConductor, 0.02f},
                    BsdfCase{BsdfKind::kMetallicRoughness, 0.1f}, BsdfCase{BsdfKind::kOrenNayar},
                    BsdfCase{BsdfKind::kDiffuseTransmission},
                    BsdfCase{BsdfKind::kRoughDielectric, 0.2f}, BsdfCase{BsdfKind::kPhong},
                    BsdfCase{BsdfKind::kMirror}, BsdfCase{BsdfKind::kDielectric},
                    BsdfCase{BsdfKind::kThinDielectric}),
    [](const auto& test) {
      std::string name(Bsdfs()[int(test.param.kind)].name);
      std::erase(name, '-');
      return name + std::to_string(int(test.param.alpha * 100));
    });

// Where light paths pass through glass of two widths, its tangent is seen from behind.
TEST(Bdpt, GlassOfTwoWidthsMatchesPathTracing) {
  Material glass = Of(BsdfKind::kRoughDielectric, 0.4f);
  glass.alpha_across = 0.1f;
  EXPECT_TRUE(SameAsPaths(MattRoom(glass, kEnvironment | kLamp), Request(Integrator::kBdpt, 5),
                          kRuns, kLevel));
}

TEST(Bdpt, EveryDepthMatchesPathTracing) {
  const Scene scene = MattRoom(Of(BsdfKind::kConductor), kEnvironment | kLamp | kPoint);
  for (const std::uint32_t depth : {0u, 1u, 2u, 3u, 7u}) {
    SCOPED_TRACE(depth);
    EXPECT_TRUE(SameAsPaths(scene, Request(Integrator::kBdpt, depth), kRuns, kLevel));
  }
}

// Tests lenses and every kind of camera.
TEST(Bdpt, EveryCameraMatchesPathTracing) {
  const Scene scene = MattRoom(Of(BsdfKind::kDielectric), kEnvironment | kLamp);
  for (const CameraKind kind : kCameraKinds) {
    for (const float lens : {0.0f, 0.3f}) {
      if (lens > 0 && !HasPlaneFilm(kind)) continue;
      SCOPED_TRACE(std::string(ToString(kind)) + " " + std::to_string(lens));
      JobRequest request = Request(Integrator::kBdpt, 4);
      request.camera.kind = kind;
      request.camera.lens_radius = lens;
      EXPECT_TRUE(SameAsPaths(scene, request, kRuns, kLevel));
    }
  }
}

// Some surfaces, among them a lamp, let rays pass by chance.
TEST(Bdpt, SurfacesWithAlphaMatchPathTracing) {
  Material veil = Of(BsdfKind::kLambert);
  veil.opacity = 0.4f;
  Scene scene = MattRoom(veil, kEnvironment | kLamp | kPoint);
  for (Material& material : scene.materials) {
    if (material.name == "lamp") material.opacity = 0.7f;
  }
  EXPECT_TRUE(SameAsPaths(scene, Request(Integrator::kBdpt, 4), kRuns, kLevel));
}

std::vector<SubpathLengths> TechniquesOf(std::uint32_t surfaces) {
  std::vector<SubpathLengths> techniques;
  for (std::uint32_t light = 0; light <= surfaces + 1; ++light) {
    const SubpathLengths technique = {.light = light, .eye = surfaces + 2 - light};
    if (light != 1 || technique.eye != 1) techniques.push_back(technique);
  }
  return techniques;
}

// The surfaces are far from each other, because unweighted connections in corners have unbounded
// variance.
Scene Apart(const Material& material) {
  Scene scene;
  Place(scene, Facetted(Quad(3)), AddLambert(scene, "floor", {0.7f, 0.6f, 0.5f}), glm::vec3(0));
  scene.materials.push_back(material);
  const auto index = std::uint32_t(scene.materials.size() - 1);
  Place(scene, Facetted(Sphere(0.4f, 3)), index, {-0.7f, 1.1f, 0});
  Place(scene, Facetted(Sphere(0.4f, 3)), index, {0.8f, 1.2f, 0.3f}, 30);
  AddLamp(scene, 2.5f, {0.2f, 3, 0}, {3, 2, 1});
  SetConstantLight(scene, 0.5f);
  scene.camera = LookAtCamera({0.4f, 1.9f, 4.5f}, {0, 0.8f, 0}, {0, 1, 0}, 44, false);
  return scene;
}

// If no BSDF and no light is a delta distribution, each technique alone estimates all light of its
// path length.
TEST(Bdpt, EveryTechniqueAloneFindsAllLight) {
  for (const BsdfKind kind : {BsdfKind::kLambert, BsdfKind::kRoughDielectric}) {
    const RenderJob job(Apart(Of(kind, 0.5f)), Request(Integrator::kBdpt, 3));
    // Three surfaces can be facets of one glass ball, with corners between them.
    for (std::uint32_t surfaces = 1; surfaces <= (kind == BsdfKind::kLambert ? 3 : 2); ++surfaces) {
      PictureEstimate expected;
      std::uint32_t seed = 100;
      for (const SubpathLengths& technique : TechniquesOf(surfaces)) {
        SCOPED_TRACE(std::to_string(technique.light) + "," + std::to_string(technique.eye));
        FrameView frame = job.frame();
        frame.options.of<ConnectionOptions>().shown = technique;
        frame.options.mis = false;
        const PictureEstimate alone =
            MeanOfBlocks(EstimateFromEngine(job, frame, kRuns, seed += 100), 6);
        if (technique.light == 0) {
          expected = alone;
        } else {
          EXPECT_TRUE(SamePicture(alone, expected, kLevel));
        }
      }
    }
  }
}

TEST(Bdpt, WeightedTechniquesAddUpToThePicture) {
  const RenderJob job(MattRoom(Of(BsdfKind::kDielectric), kEnvironment | kLocal),
                      Request(Integrator::kBdpt, 4));
  const auto render = [&](const std::optional<SubpathLengths>& technique) {
    FrameView frame = job.frame();
    frame.options.of<ConnectionOptions>().shown = technique;
    Film film = job.MakeFilm();
    RenderFrame(frame, film);
    return film.Resolve(frame.options.samples_per_pixel).rgb;
  };
  const std::vector<float> picture = render(std::nullopt);
  std::vector<double> sum(picture.size());
  for (std::uint32_t surfaces = 0; surfaces <= 4; ++surfaces) {
    for (const SubpathLengths& technique : TechniquesOf(surfaces)) {
      const std::vector<float> part = render(technique);
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += part[i];
    }
  }
  for (std::size_t i = 0; i < sum.size(); ++i) ASSERT_NEAR(sum[i], picture[i], 1e-4 * picture[i]);
}

TEST(Bdpt, UnsupportedOptionsAreRefused) {
  const Scene scene = MattRoom(Of(BsdfKind::kLambert), kEnvironment | kLamp);
  const auto refused = [&](auto change) {
    JobRequest request = Request(Integrator::kBdpt, 3);
    change(request);
    EXPECT_THROW(RenderJob(scene, request), InputError);
  };
  refused([](JobRequest& r) { r.options.mis = false; });
  refused([](JobRequest& r) { r.max_depth = kMaxBidirectionalDepth + 1; });
  refused([](JobRequest& r) { r.strategy = "cosine"; });
  refused([](JobRequest& r) {
    r.options.of<ConnectionOptions>().shown = SubpathLengths{.light = 1, .eye = 1};
  });
  refused([](JobRequest& r) {
    r.options.of<ConnectionOptions>().shown = SubpathLengths{.light = 3, .eye = 0};
  });
  refused([](JobRequest& r) {
    r.options.of<ConnectionOptions>().shown = SubpathLengths{.light = 1, .eye = 2};
    r.integrator = Integrator::kPath;
  });
  // These lengths connect four surfaces, one more than the depth.
  refused([](JobRequest& r) {
    r.options.of<ConnectionOptions>().shown = SubpathLengths{.light = 2, .eye = 4};
  });
  refused([](JobRequest& r) {
    r.options.of<ConnectionOptions>().shown = SubpathLengths{.light = ~0u, .eye = ~0u};
  });
  JobRequest alone = Request(Integrator::kBdpt, 3);
  alone.options.mis = false;
  alone.options.of<ConnectionOptions>().shown = SubpathLengths{.light = 1, .eye = 2};
  EXPECT_NO_THROW(RenderJob(scene, alone));
}

// Choices at the two ends of a connection are independent: a mixture of matt surfaces is as bright
// as a matt surface of their mean.
TEST(Bdpt, MixturesChooseIndependentlyAtBothEnds) {
  const auto estimate = [](bool mixed, Integrator integrator) {
    Scene scene;
    AddLambert(scene, "dark", glm::vec3(0.02f)), AddLambert(scene, "bright", glm::vec3(0.95f));
    AddLambert(scene, "mean", glm::vec3(0.5f * (0.02f + 0.95f)));
    scene.materials.push_back({.name = "mixture", .mixture = Mixture{0, 1, 0.5f}});
    Mesh room = Facetted(RoundedBox(glm::vec3(1), 1e-3f, 1));
    FlipOrientation(room);
    Place(scene, room, mixed ? 3 : 2, glm::vec3(0));
    AddLamp(scene, 0.8f, {0, 0.9f, 0}, glm::vec3(4));
    scene.camera = LookAtCamera({0, 0, -0.9f}, {0, -0.3f, 1}, {0, 1, 0}, 70, false);
    JobRequest request = Request(integrator, 4);
    request.samples_per_pixel = integrator == Integrator::kPath ? 256 : 64;
    return MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), kRuns, mixed ? 100 : 1000),
                        3);
  };
  EXPECT_TRUE(
      SamePicture(estimate(true, Integrator::kBdpt), estimate(false, Integrator::kPath), kLevel));
}

}  // namespace
}  // namespace skywave
