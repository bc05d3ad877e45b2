// Compares vertex connection and merging with paths, photon maps, closed forms and bidirectional
// paths.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/support/matt_room.h"
#include "tests/support/photon_maps.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"
#include "tests/support/rendered_image.h"
#include "tests/support/same_bits.h"
#include "tests/support/shining_cave.h"
#include "tests/support/statistics.h"
#include "wavefront/passes/merging_pass.h"
#include "wavefront/policies/emission_pilot.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render.h"
#include "wavefront/stages/bidirectional.h"

namespace skywave {
namespace {

constexpr int kRuns = 12;
// This many comparisons of pictures share the level of the test program.
const double kLevel = SidakLevel(35);

// The radius is small enough for its bias to vanish in the noise, and one pass has so many light
// paths that merging still contributes.
JobRequest Request(std::uint32_t max_depth, float radius) {
  JobRequest request = SmallRequest(24, 18, 32);
  request.integrator = Integrator::kVcm;
  request.max_depth = max_depth;
  request.options.of<PhotonOptions>().distance = radius;
  request.options.of<PhotonOptions>().passes = 1;
  return request;
}
constexpr float kSmallRadius = 0.02f;

class VcmLights : public testing::TestWithParam<int> {};

TEST_P(VcmLights, PicturesMatchPathTracing) {
  EXPECT_TRUE(SameAsPaths(MattRoom(Of(BsdfKind::kLambert), GetParam()), Request(4, kSmallRadius),
                          kRuns, kLevel));
}
INSTANTIATE_TEST_SUITE_P(Vcm, VcmLights,
                         testing::Values(kEnvironment, kLamp, kPoint, kDistant, kShaped,
                                         kEnvironment | kLocal),
                         [](const auto& test) { return "Lights" + std::to_string(test.param); });

struct BsdfCase {
  BsdfKind kind;
  float alpha = 0.3f;
};
void PrintTo(const BsdfCase& test, std::ostream* out) { *out << Bsdfs()[int(test.kind)].name; }
class VcmBsdfs : public testing::TestWithParam<BsdfCase> {};

TEST_P(VcmBsdfs, PicturesMatchPathTracing) {
  const BsdfCase& test = GetParam();
  EXPECT_TRUE(SameAsPaths(MattRoom(Of(test.kind, test.alpha), kEnvironment | kLamp),
                          Request(5, kSmallRadius), kRuns, kLevel));
}
INSTANTIATE_TEST_SUITE_P(Vcm, VcmBsdfs,
                         testing::Values(BsdfCase{BsdfKind::kConductor, 0.15f},
                                         BsdfCase{BsdfKind::kDiffuseTransmission},
                                         BsdfCase{BsdfKind::kRoughDielectric, 0.2f},
                                         BsdfCase{BsdfKind::kMirror},
                                         BsdfCase{BsdfKind::kDielectric}),
                         [](const auto& test) {
                           std::string name(Bsdfs()[int(test.param.kind)].name);
                           std::erase(name, '-');
                           return name;
                         });

// Most light vertices are far away on a wide floor. A radius that fits them would blur the whole
// picture.
TEST(Vcm, TheRadiusFitsWhatPixelsSee) {
  Scene scene = MattRoom(Of(BsdfKind::kLambert), kEnvironment | kLamp);
  Mesh floor = Quad(40);
  for (glm::vec3& p : floor.positions) p.y -= 0.01f;
  Place(scene, floor, 0, glm::vec3(0));
  JobRequest request = Request(4, 0);
  request.width = 640, request.height = 480;
  request.crop = CropWindow{300, 220, 24, 24};
  request.options.of<PhotonOptions>().passes = 0;
  EXPECT_TRUE(SameAsPaths(scene, request, kRuns, kLevel));
}

TEST(Vcm, OtherStrategiesMatchPathTracing) {
  for (const char* const strategy :
       {"alias", "uniform", "presampled", "median-cut:pick=power", "hybrid:pick=power"}) {
    JobRequest request = Request(4, kSmallRadius);
    request.strategy = strategy;
    EXPECT_TRUE(
        SameAsPaths(MattRoom(Of(BsdfKind::kLambert), kEnvironment | kLamp), request, kRuns, kLevel))
        << strategy;
  }
}

TEST(Vcm, LensesMatchPathTracing) {
  JobRequest request = Request(4, kSmallRadius);
  request.camera.lens_radius = 0.3f;
  EXPECT_TRUE(SameAsPaths(MattRoom(Of(BsdfKind::kDielectric), kEnvironment | kLamp), request, kRuns,
                          kLevel));
}

// Nothing is merged, so nothing is biased.
TEST(Vcm, WithoutARadiusItEqualsBdpt) {
  const Scene scene = MattRoom(Of(BsdfKind::kDielectric), kEnvironment | kLocal);
  JobRequest request = Request(4, 1e-6f);
  const PictureEstimate vcm =
      MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), kRuns, 0), 3);
  request.integrator = Integrator::kBdpt;
  const PictureEstimate bdpt =
      MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), kRuns, 500), 3);
  EXPECT_TRUE(SamePicture(vcm, bdpt, kLevel));
}

// Returns the contribution of merges to a picture, weighted or not: the lengths given match no
// connection.
Image MergesOf(const RenderJob& job, bool weighted) {
  FrameView frame = job.frame();
  frame.options.of<ConnectionOptions>().shown = SubpathLengths{.light = 0, .eye = 1000};
  frame.options.mis = weighted;
  Film film = job.MakeFilm();
  RenderFrame(frame, film);
  return film.Resolve(job.options().samples_per_pixel);
}

// Without weights, a path is found once at each of its surfaces: inside a cave that emits and
// reflects uniformly, light that has hit n surfaces counts n times.
TEST(Vcm, MergesAloneFindAPathAtEachOfItsSurfaces) {
  for (const std::uint32_t depth : {1u, 3u}) {
    for (const PhotonKernel kernel : {PhotonKernel::kConstant, PhotonKernel::kEpanechnikov}) {
      JobRequest request = Request(depth, 0.05f);
      request.options.of<PhotonOptions>().kernel = kernel;
      request.camera.kind = CameraKind::kEqualArea;  // shows all of the cave
      request.width = request.height = 24;
      const RenderJob job(ShiningCave(), request);
      const Image merges = MergesOf(job, /*weighted=*/false);
      for (int c = 0; c < 3; ++c) {
        double expected = 0;
        for (std::uint32_t i = 1; i <= depth; ++i) {
          expected += i * kCaveEmission * std::pow(double(kCaveAlbedo[c]), i);
        }
        EXPECT_NEAR(MeanOf(merges, std::size_t(c)) / expected, 1, 0.01)
            << "depth " << depth << ", channel " << c;
      }
    }
  }
}

TEST(Vcm, CaveIsAsBrightAsItsSeries) {
  for (const float radius : {0.05f, 0.2f}) {
    JobRequest request = Request(5, radius);
    request.options.of<PhotonOptions>().passes = 0;
    const RenderJob job(ShiningCave(), request);
    const Image picture = Render(job);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(MeanOf(picture, std::size_t(c)) / CaveRadiance(c, 5), 1, 0.01)
          << "radius " << radius << ", channel " << c;
    }
    // Merging contributes to that.
    const double merges = MeanOf(MergesOf(job, /*weighted=*/true), 0);
    EXPECT_GT(merges, (radius > 0.1f ? 0.05 : 0.0005) * MeanOf(picture, 0));
  }
}

// A floor and a point light in front of a mirror, in which the floor is seen: it is lit by the
// point and by the mirror image of the point, which no connection finds.
Scene FloorInAMirror() {
  Scene scene;
  Place(scene, Quad(2), AddLambert(scene, "floor", glm::vec3(0.7f)), glm::vec3(0));
  scene.materials.push_back(Of(BsdfKind::kMirror));
  scene.materials.back().reflectance = glm::vec3(1);
  Mesh wall = Quad(2);
  for (glm::vec3& p : wall.positions) p = {p.x, p.z + 1, 2};
  Place(scene, Facetted(wall), std::uint32_t(scene.materials.size() - 1), glm::vec3(0));
  scene.lights.push_back({.emission = {4, 3, 2}, .position = {0.3f, 2.6f, 0.2f}});
  SetConstantLight(scene, 0);
  scene.camera = LookAtCamera({0, 1.2f, -0.5f}, {0, 0.75f, 2}, {0, 1, 0}, 36, false);
  return scene;
}

TEST(Vcm, CausticsAreSeenInMirrors) {
  const Scene scene = FloorInAMirror();
  JobRequest request = Request(4, 0.1f);
  const auto mean = [&](Integrator integrator) {
    request.integrator = integrator;
    return MeanOf(Render(RenderJob(scene, request)), 1);
  };
  request.samples_per_pixel = 128;
  const double vcm = mean(Integrator::kVcm), bdpt = mean(Integrator::kBdpt);
  request.samples_per_pixel = 8;
  request.options.of<PhotonOptions>().gather = 0;
  const double photon = mean(Integrator::kPhoton);
  std::printf("vcm %.4f, photon %.4f, bdpt %.4f\n", vcm, photon, bdpt);
  EXPECT_NEAR(vcm / photon, 1, 0.02);
  EXPECT_LT(bdpt, 0.85 * photon) << "the mirror's light is no small part";
}

// The vertices of a cave are even on its surface, so the distance within which there are so many of
// them follows from their number.
TEST(Vcm, RadiusIsHalfOfTheDistanceToTheNeighbors) {
  for (const std::uint32_t samples : {32u, 256u}) {
    for (const std::uint32_t neighbors : {50u, 200u}) {  // smaller than what pixels see
      JobRequest request = Request(1, 0);
      request.samples_per_pixel = samples;
      request.options.of<PhotonOptions>().neighbors = neighbors;
      const RenderJob job(ShiningCave(), request);
      const FrameView frame = job.frame();
      WorkerPool pool = TwoThreads(frame);
      MergePlan plan = {};
      pool.Run([&] { plan = PlanMerging(frame, pool); });
      EXPECT_EQ(plan.light_paths, 24u * 18 * samples);  // each of them has one vertex
      const double area = 4 * std::numbers::pi;
      const double reach = std::sqrt(neighbors * area / (std::numbers::pi * plan.light_paths));
      // The sphere is curved and faceted, and the middle of 255 distances is not their mean.
      EXPECT_NEAR(plan.radius / (0.5 * reach), 1, 0.04) << samples << ", " << neighbors;
    }
  }
}

// By Knaus and Zwicker 2011, eq. 15, the square of the radius has shrunk by a quotient of gamma
// functions.
TEST(Vcm, TheRadiusOfTheLastPassFollowsTheFormula) {
  constexpr double kAlpha = 2.0 / 3, kFirst = 0.2;
  for (const std::uint32_t passes : {1u, 16u}) {
    JobRequest request = Request(2, float(kFirst));
    request.samples_per_pixel = passes;
    request.options.of<PhotonOptions>().passes = 0;
    const RenderJob job(ShiningCave(), request);
    const FrameView frame = job.frame();
    WorkerPool pool = TwoThreads(frame);
    PhotonCounts counts;
    pool.Run([&] { ForEachPass(frame, pool, counts, [](const FrameView&) { return true; }); });
    const double n = passes - 1.0;
    const double log2 = std::lgamma(n + 1 + kAlpha) - std::lgamma(1 + kAlpha) - std::lgamma(n + 2);
    EXPECT_NEAR(counts.radius, kFirst * std::exp(log2 / 2), 1e-5) << passes << " passes";
  }
}

// A sample has the same pass in every picture that has one, whichever samples that begins with.
TEST(Vcm, PassesDoNotDependOnTheFirstSample) {
  const auto passes_of = [](std::uint32_t first, std::uint32_t end) {
    RenderOptions options;
    options.integrator = Integrator::kVcm;
    options.of<PhotonOptions>().passes = 0;
    options.picture_samples = {first, end};
    return PhotonPasses(options);
  };
  const std::vector<PhotonPass> whole = passes_of(0, 16), part = passes_of(7, 16);
  ASSERT_EQ(whole.size(), 16u);
  ASSERT_EQ(part.size(), 9u);
  for (std::size_t i = 0; i < part.size(); ++i) {
    EXPECT_EQ(part[i].samples.first, whole[i + 7].samples.first);
    EXPECT_EQ(part[i].samples.end, whole[i + 7].samples.end);
    EXPECT_EQ(part[i].shrink, whole[i + 7].shrink) << i;
    EXPECT_LT(whole[i + 7].shrink, whole[i + 6].shrink) << i;
  }
}

// Radii shrink, and with them the blur of a large first radius.
TEST(Vcm, PassesConverge) {
  const Scene scene = MattRoom(Of(BsdfKind::kDielectric), kLamp);
  JobRequest request = Request(4, kSmallRadius);
  request.integrator = Integrator::kPath;
  request.samples_per_pixel = 2048;
  request.options.seed = 77;
  const Image reference = Render(RenderJob(scene, request));
  request = Request(4, 1.0f);
  request.options.of<PhotonOptions>().passes = 0;
  double before = 0;
  for (const std::uint32_t passes : {2u, 16u, 128u}) {
    request.samples_per_pixel = passes;
    const Image picture = Render(RenderJob(scene, request));
    double sum = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
      sum += std::pow(double(picture.rgb[i]) - double(reference.rgb[i]), 2);
    }
    std::printf("%3u passes: %.3g\n", passes, sum);
    if (before > 0) {
      EXPECT_LT(sum, 0.5 * before);
    }
    before = sum;
  }
}

// The number of light vertices is limited, so that waves end within the stored ones.
TEST(Vcm, ThreadsAndWavesDoNotMatter) {
  const Scene scene = MattRoom(Of(BsdfKind::kConductor), kEnvironment | kLocal);
  for (const std::uint32_t passes : {0u, 1u, 3u}) {
    JobRequest request = Request(4, 0);
    request.samples_per_pixel = 5;
    request.options.of<PhotonOptions>().passes = passes;
    request.options.of<PhotonOptions>().indirect = 500;
    request.options.of<GuideOptions>().guide = passes != 1;
    const RenderJob job(scene, request);
    ExpectSameBits(job);
  }
}

TEST(Vcm, PhotonsBoundWhatAPassStores) {
  const Scene scene = MattRoom(Of(BsdfKind::kLambert), kLamp);
  const auto vertices = [&](std::uint32_t photons) {
    JobRequest request = Request(4, 0);
    request.samples_per_pixel = 4;
    request.options.of<PhotonOptions>().passes = 0;
    request.options.of<PhotonOptions>().indirect = photons;
    request.options.of<PhotonOptions>().neighbors = 3;
    const RenderJob job(scene, request);
    Film film = job.MakeFilm();
    return RenderFrame(job.frame(), film).photons;
  };
  const PhotonCounts few = vertices(200), all = vertices(1000000);
  EXPECT_NEAR(double(few.indirect) / (4 * 200), 1, 0.1);
  EXPECT_EQ(all.light_paths, 4u * 24 * 18);
  EXPECT_GT(few.radius, all.radius);
}

TEST(Vcm, RefusesImpossibleRequests) {
  const Scene scene = MattRoom(Of(BsdfKind::kLambert), kEnvironment | kLamp);
  const auto refused = [&](const std::string& word, auto change) {
    JobRequest request = Request(3, 0);
    change(request);
    ExpectRefused(scene, request, word);
  };
  refused("no-mis", [](JobRequest& r) { r.options.mis = false; });
  refused("max-depth", [](JobRequest& r) { r.max_depth = kMaxBidirectionalDepth + 1; });
  refused("cosine", [](JobRequest& r) { r.strategy = "cosine"; });
  refused("paths", [](JobRequest& r) {
    r.options.of<ConnectionOptions>().shown = SubpathLengths{.light = 1, .eye = 2};
  });
  refused("photons 0", [](JobRequest& r) { r.options.of<PhotonOptions>().indirect = 0; });
  refused("spp", [](JobRequest& r) { r.options.of<PhotonOptions>().passes = 33; });
  refused("photon-distance", [](JobRequest& r) { r.options.of<PhotonOptions>().distance = 100; });
  refused("variance", [](JobRequest& r) { r.options.aovs = *ParseAovs("variance"); });
  Scene dark = MattRoom(Of(BsdfKind::kLambert), 0);
  SetConstantLight(dark, 0);
  ExpectRefused(dark, Request(3, 0), "nothing shines");
}

// In these scenes no light path hits a surface that could be merged.
TEST(Vcm, RendersWithoutLightVertices) {
  Scene scene;
  scene.materials.push_back(Of(BsdfKind::kMirror));
  Place(scene, Facetted(Sphere(1, 8)), 0, glm::vec3(0));
  SetConstantLight(scene, 1);
  for (const std::uint32_t depth : {0u, 3u}) {
    JobRequest request = Request(depth, 0);
    request.samples_per_pixel = 4;
    EXPECT_GT(MeanOf(Render(RenderJob(scene, request)), 0), 0.1);
  }
}

}  // namespace
}  // namespace skywave
