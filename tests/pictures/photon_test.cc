// Compares photon mapping with closed forms, path tracing and itself.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "scene/shapes/mesh.h"
#include "tests/support/matt_room.h"
#include "tests/support/photon_maps.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"
#include "tests/support/rendered_image.h"
#include "tests/support/same_bits.h"
#include "tests/support/shining_cave.h"
#include "tests/support/statistics.h"
#include "wavefront/option_names.h"
#include "wavefront/policies/emission_pilot.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

std::array<double, 3> MeanOf(const Image& image) {
  std::array<double, 3> mean = {};
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    mean[i % 3] += 3 * double(image.rgb[i]) / double(image.rgb.size());
  }
  return mean;
}

struct CaveCase {
  const char* name;
  std::uint32_t gather, passes;
  PhotonKernel kernel;
};
constexpr CaveCase kCaveCases[] = {{"constant", 0, 1, PhotonKernel::kConstant},
                                   {"cone", 0, 1, PhotonKernel::kCone},
                                   {"epanechnikov", 0, 1, PhotonKernel::kEpanechnikov},
                                   {"gather", 3, 1, PhotonKernel::kConstant},
                                   {"progressive cone", 0, 4, PhotonKernel::kCone},
                                   {"progressive gather", 2, 4, PhotonKernel::kEpanechnikov}};

// The error is not noise alone: the disk of a lookup is flat while the cave is curved, and all
// pixels share the photons of a map. Their number limits the error to one percent.
TEST(Photon, CaveIsAsBrightAsItsSeries) {
  for (const CaveCase& test : kCaveCases) {
    for (const std::uint32_t depth : {1u, 5u}) {
      SCOPED_TRACE(std::string(test.name) + ", depth " + std::to_string(depth));
      JobRequest request = PhotonRequest(10, 10, 16, depth);
      request.options.of<PhotonOptions>().gather = test.gather;
      request.options.of<PhotonOptions>().passes = test.passes;
      request.options.of<PhotonOptions>().kernel = test.kernel;
      const RenderJob job(ShiningCave(), request);
      const std::array<double, 3> mean = MeanOf(Render(job));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(mean[std::size_t(c)] / CaveRadiance(c, depth), 1, 0.01) << "channel " << c;
      }
    }
  }
}

// Returns the inside of a box that emits and reflects uniformly, containing a smaller one that does
// too: the radiance is the same everywhere.
Scene ShiningRoom(glm::vec3 half_sides, glm::vec3 middle, float turn, const Camera& camera) {
  Scene scene;
  const std::uint32_t wall = AddLambert(scene, "wall", kCaveAlbedo);
  scene.materials[wall].emission = glm::vec3(kCaveEmission);
  Mesh room = Facetted(RoundedBox(glm::vec3(1), 1e-3f, 1));
  FlipOrientation(room);
  Place(scene, room, wall, glm::vec3(0));
  Place(scene, Facetted(RoundedBox(half_sides, 1e-3f, 1)), wall, middle, turn);
  scene.camera = camera;
  return scene;
}

// Compares photons of the walls with the closed form: looked up with the given number of neighbours
// at visible points, and at those that these see.
void ExpectCaveRadiance(const Scene& scene, int side, std::uint32_t neighbors, double tolerance) {
  for (const std::uint32_t gather : {0u, 1u}) {
    for (const std::uint32_t passes : {1u, 4u}) {
      JobRequest request = PhotonRequest(side, side, 16, 4);
      request.options.of<PhotonOptions>().gather = gather;
      request.options.of<PhotonOptions>().passes = passes;
      request.options.of<PhotonOptions>().neighbors = neighbors;
      request.options.of<PhotonOptions>().indirect = 60000;
      const std::array<double, 3> mean = MeanOf(Render(RenderJob(scene, request)));
      for (int c = 0; c < 3; ++c) {
        const double ratio = mean[std::size_t(c)] / CaveRadiance(c, 4);
        EXPECT_NEAR(ratio, 1, tolerance)
            << "gather " << gather << ", passes " << passes << ", channel " << c;
      }
    }
  }
}

// If photons were divided by the whole area of their disk, the picture would be too dark near edges
// and corners.
TEST(Photon, EdgesAndCornersAreNoDarker) {
  const Camera camera = LookAtCamera({-0.8f, -0.7f, -0.8f}, {0.1f, 0, 0.1f}, {0, 1, 0}, 85, false);
  ExpectCaveRadiance(ShiningRoom(glm::vec3(0.25f), {0.3f, 0.2f, 0.3f}, 30, camera), 24, 150, 0.007);
}

// A shelf close above the floor is seen from above: photons of the floor lie within its disks and
// face the same direction, but are hidden by it.
TEST(Photon, LightBehindASurfaceDoesNotLeak) {
  const Camera above = LookAtCamera({0, 0.9f, 0}, {0, -0.9f, 0.01f}, {0, 0, 1}, 40, false);
  ExpectCaveRadiance(ShiningRoom({0.8f, 0.02f, 0.8f}, {0, -0.9f, 0}, 0, above), 16, 400, 0.01);
}

// The product of Knaus and Zwicker 2011, eq. 15, is a quotient of gamma functions.
TEST(Photon, RadiiShrinkByTheFormula) {
  for (const float alpha : {0.3f, 2.0f / 3, 0.9f}) {
    JobRequest request = PhotonRequest(8, 8, 400, 3);
    request.options.of<PhotonOptions>().passes = 200;
    request.options.of<PhotonOptions>().alpha = alpha;
    const RenderJob job(ShiningCave(), request);
    const std::vector<PhotonPass> passes = PhotonPasses(job.options());
    ASSERT_EQ(passes.size(), 200u);
    for (std::size_t i = 0; i < passes.size(); ++i) {
      const double n = double(i);
      const double log2 = std::lgamma(n + 1 + alpha) - std::lgamma(1 + alpha) - std::lgamma(n + 2);
      ASSERT_NEAR(passes[i].shrink, std::exp(log2 / 2), 1e-5) << "pass " << i;
    }
  }
}

// Photons come in rounds; the first rounds may have few of them.
TEST(Photon, ThreadsAndWavesDoNotMatter) {
  Scene scene = UnderGlass();
  SetLight(scene, SkyWithSun(32, 16, 40, 0.3));
  for (const std::uint32_t passes : {1u, 3u}) {
    for (const std::uint32_t gather : {0u, 2u}) {
      JobRequest request = PhotonRequest(13, 11, 5, 6);
      request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic =
          3000;
      request.options.of<PhotonOptions>().passes = passes;
      request.options.of<PhotonOptions>().gather = gather;
      request.options.of<GuideOptions>().guide = passes > 1;
      const RenderJob job(scene, request);
      ExpectSameBits(job);
    }
  }
}

constexpr int kBlock = 4, kSide = 16;  // [pixels]

// Returns the root mean square difference of the means of blocks over the root mean square of `b`.
double Difference(const Image& a, const Image& b) {
  double sum = 0, scale = 0;
  for (int y = 0; y < kSide; y += kBlock) {
    for (int x = 0; x < 3 * kSide; x += kBlock * 3) {
      double of_a[3] = {}, of_b[3] = {};
      for (int i = 0; i < kBlock; ++i) {
        for (int j = 0; j < kBlock * 3; ++j) {
          of_a[j % 3] += double(a.Pixel(x / 3, y + i)[j]);
          of_b[j % 3] += double(b.Pixel(x / 3, y + i)[j]);
        }
      }
      for (int c = 0; c < 3; ++c) {
        sum += std::pow(of_a[c] - of_b[c], 2);
        scale += of_b[c] * of_b[c];
      }
    }
  }
  return std::sqrt(sum / scale);
}

Image PathTraced(const Scene& scene, JobRequest request, std::uint32_t samples) {
  request.integrator = Integrator::kPath;
  request.samples_per_pixel = samples;
  request.options.seed = 99;
  return Render(RenderJob(scene, request));
}

// A room of coloured walls with a lamp, a glass ball, a mirror and gloss has caustics and
// interreflection, under a lamp large enough for path tracing to hit.
Scene Room() {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "white", glm::vec3(0.7f));
  Mesh box = RoundedBox(glm::vec3(1), 0.01f, 1);
  FlipOrientation(box);
  Place(scene, Facetted(box), white, {0, 1, 0});
  Place(scene, Facetted(Sphere(0.35f, 10)), AddGlass(scene, 1.5f), {0.4f, 0.4f, 0.3f});
  Place(scene, Facetted(Sphere(0.3f, 8)), AddLambert(scene, "red", {0.8f, 0.2f, 0.1f}),
        {-0.45f, 0.3f, 0.35f});
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
  scene.materials[lamp].emission = {4, 4, 3};
  Mesh quad = Quad(0.4f);
  FlipOrientation(quad);
  Place(scene, quad, lamp, {0, 1.9f, 0});
  scene.camera = LookAtCamera({0, 1, -0.8f}, {0, 0.6f, 1}, {0, 1, 0}, 75, false);
  return scene;
}

// Returns a slot that is ten times as deep as wide, under a constant sky, and a camera that looks
// at one of its walls from the other.
Scene Slot(float y) {
  Scene scene;
  const std::uint32_t wall = AddLambert(scene, "wall", glm::vec3(0.9f));
  Mesh slot = Facetted(RoundedBox({0.05f, 0.5f, 0.5f}, 1e-3f, 1));
  FlipOrientation(slot);
  std::erase_if(slot.triangles, [&](const glm::uvec3& t) {
    return slot.positions[t.x].y > 0.49f && slot.positions[t.y].y > 0.49f &&
           slot.positions[t.z].y > 0.49f;
  });
  Place(scene, slot, wall, {0, -0.5f, 0});
  SetConstantLight(scene, 1);
  scene.camera = LookAtCamera({0.04f, y, 0}, {-0.05f, y, 0}, {0, 1, 0}, 40, false);
  return scene;
}

double PhotonsOverPaths(const Scene& scene, const JobRequest& request) {
  const Image reference = PathTraced(scene, request, 2048);
  return MeanOf(Render(RenderJob(scene, request)))[0] / MeanOf(reference)[0];
}

// Light falls off fast, and disks are nearly as large as the slot is deep, so rays of a gather that
// looked photons up at the other wall would be off by 16 and 13 %. What is left is the blur of
// longer rays.
TEST(Photon, ShortRaysOfAGatherContinue) {
  JobRequest request = PhotonRequest(8, 8, 256, 6);
  request.options.of<PhotonOptions>().indirect = 20000;
  request.options.of<PhotonOptions>().neighbors = 10000;
  request.options.of<PhotonOptions>().distance = 0.4f;
  for (const float y : {-0.15f, -0.3f}) {
    EXPECT_NEAR(PhotonsOverPaths(Slot(y), request), 1, 0.04) << y;
  }
}

// Below a pane all light that the walls get from the sky is a caustic, and without those of nearby
// walls more than a quarter would be missing.
TEST(Photon, ShortRaysOfAGatherSeeCaustics) {
  Scene scene = Slot(-0.3f);
  const std::uint32_t pane = AddGlass(scene, 1.5f);
  scene.materials[pane].bsdf = BsdfKind::kThinDielectric;
  Place(scene, Quad(1), pane, glm::vec3(0));
  JobRequest request = PhotonRequest(8, 8, 256, 6);
  request.options.of<PhotonOptions>().indirect = 20000;
  request.options.of<PhotonOptions>().caustic = 200000;
  request.options.of<PhotonOptions>().neighbors = 1000;
  EXPECT_NEAR(PhotonsOverPaths(scene, request), 1, 0.1);
}

// With smaller disks and more photons, both bias and noise decrease.
TEST(Photon, DifferenceFromPathTracingFallsWithPhotons) {
  const Scene scene = Room();
  const Image reference = PathTraced(scene, PhotonRequest(kSide, kSide, 1, 5), 4096);
  for (const std::uint32_t gather : {0u, 2u}) {
    double before = 0;
    for (const std::uint32_t photons : {500u, 8000u, 128000u}) {
      SCOPED_TRACE("gather " + std::to_string(gather) + ", photons " + std::to_string(photons));
      JobRequest request = PhotonRequest(kSide, kSide, 256, 5);
      request.options.of<PhotonOptions>().gather = gather;
      request.options.of<PhotonOptions>().indirect = photons;
      request.options.of<PhotonOptions>().caustic = photons / 4;
      const double difference = Difference(Render(RenderJob(scene, request)), reference);
      std::printf("gather %u, %6u photons: %.4f\n", gather, photons, difference);
      if (before > 0) {
        EXPECT_LT(difference, 0.75 * before);
      }
      before = difference;
    }
    EXPECT_LT(before, 0.03);
  }
}

// Most photons are far away on a wide floor. Radii that fit them would blur the whole picture.
TEST(Photon, ProgressiveRadiiFitWhatPixelsSee) {
  Scene scene = MattRoom(Of(BsdfKind::kLambert), kEnvironment);
  Mesh floor = Quad(40);
  for (glm::vec3& p : floor.positions) p.y -= 0.01f;
  Place(scene, floor, 0, glm::vec3(0));
  JobRequest request = PhotonRequest(160, 120, 8, 4);
  request.options.of<PhotonOptions>().indirect = 100000;
  const std::array<double, 3> expected = MeanOf(PathTraced(scene, request, 64));
  request.options.of<PhotonOptions>().passes = 8;
  for (const std::uint32_t gather : {0u, 1u}) {
    request.options.of<PhotonOptions>().gather = gather;
    const std::array<double, 3> mean = MeanOf(Render(RenderJob(scene, request)));
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(mean[c] / expected[c], 1, 0.01) << "gather " << gather;
  }
}

// A pixel is as large in a part of a film as in the whole.
TEST(Photon, PartsHaveTheRadiusOfTheWhole) {
  const Scene scene = MattRoom(Of(BsdfKind::kLambert), kEnvironment | kLamp);
  for (const CameraKind kind : kCameraKinds) {
    SCOPED_TRACE(ToString(kind));
    const auto radius = [&](const std::optional<CropWindow>& crop) {
      JobRequest request = PhotonRequest(96, 64, 2, 3);
      request.options.of<PhotonOptions>().indirect = 500;
      request.options.of<PhotonOptions>().passes = 2;
      request.camera.kind = kind;
      request.crop = crop;
      const RenderJob job(scene, request);
      Film film = job.MakeFilm();
      return RenderFrame(job.frame(), film).photons.radius;
    };
    EXPECT_EQ(radius(CropWindow{16, 16, 16, 8}), radius(std::nullopt));
  }
}

TEST(Photon, ProgressivePassesConverge) {
  const Scene scene = Room();
  const Image reference = PathTraced(scene, PhotonRequest(kSide, kSide, 1, 5), 4096);
  double before = 0;
  for (const std::uint32_t passes : {2u, 16u, 128u}) {
    SCOPED_TRACE(passes);
    JobRequest request = PhotonRequest(kSide, kSide, 4 * passes, 5);
    request.options.of<PhotonOptions>().gather = 0;
    request.options.of<PhotonOptions>().indirect = 2000;
    request.options.of<PhotonOptions>().caustic = 500;
    request.options.of<PhotonOptions>().passes = passes;
    request.options.of<PhotonOptions>().distance = 0.4f;
    const double difference = Difference(Render(RenderJob(scene, request)), reference);
    std::printf("%3u passes: %.4f\n", passes, difference);
    if (before > 0) {
      EXPECT_LT(difference, 0.75 * before);
    }
    before = difference;
  }
}

TEST(Photon, RefusesImpossibleRequests) {
  Scene scene = UnderGlass();
  SetConstantLight(scene, 0);
  ExpectRefused(scene, PhotonRequest(4, 4, 1, 3), "nothing shines");
  SetConstantLight(scene, 1);
  JobRequest none = PhotonRequest(4, 4, 1, 3);
  none.options.of<PhotonOptions>().indirect = none.options.of<PhotonOptions>().caustic = 0;
  ExpectRefused(scene, none, "needs photons");
  JobRequest passes = PhotonRequest(4, 4, 3, 3);
  passes.options.of<PhotonOptions>().passes = 4;
  ExpectRefused(scene, passes, "spp");
  JobRequest layers = PhotonRequest(4, 4, 1, 3);
  layers.options.aovs = *ParseAovs("direct");
  ExpectRefused(scene, layers, "direct");
}

// Strategies that cannot start light paths still light surfaces.
TEST(Photon, TakesEveryStrategyForDirectLight) {
  Scene scene = UnderGlass();
  SetLight(scene, SkyWithSun(32, 16, 2, 0.3));
  JobRequest request = PhotonRequest(8, 6, 256, 4);
  request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic = 5000;
  const std::array<double, 3> expected = MeanOf(Render(RenderJob(scene, request)));
  for (const char* const strategy : {"product", "ris", "cosine"}) {
    SCOPED_TRACE(strategy);
    request.strategy = strategy;
    const std::array<double, 3> mean = MeanOf(Render(RenderJob(scene, request)));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(mean[c] / expected[c], 1, 0.02);
  }
}

// Rendering ends if a map cannot be filled: no light returns to a lone ball.
TEST(Photon, EndsWithoutPhotons) {
  Scene scene;
  Place(scene, Sphere(1, 8), AddLambert(scene, "ball", glm::vec3(0.5f)), glm::vec3(0));
  SetConstantLight(scene, 1);
  JobRequest request = PhotonRequest(8, 8, 4, 5);
  request.options.of<PhotonOptions>().indirect = 1000;
  request.options.of<PhotonOptions>().gather = 0;
  const RenderJob job(scene, request);
  const PhotonMaps maps = MapsOf(job);
  EXPECT_EQ(maps.indirect.size(), 0u);
  EXPECT_EQ(maps.indirect.light_paths(), 1000 * kMostPathsAPhoton);
  EXPECT_GT(MeanOf(Render(job))[0], 0);
}

}  // namespace
}  // namespace skywave
