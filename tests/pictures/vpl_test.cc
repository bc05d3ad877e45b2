// Compares virtual point lights with closed forms, path tracing and themselves.
#include <gtest/gtest.h>

#include "tests/support/matt_room.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/rendered_image.h"
#include "tests/support/shining_cave.h"
#include "tests/support/statistics.h"
#include "wavefront/policies/emission_pilot.h"
#include "wavefront/records/virtual_lights.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

JobRequest Request(int width, int height, std::uint32_t samples, float distance) {
  JobRequest request = SmallRequest(width, height, samples);
  request.integrator = Integrator::kVpl;
  request.max_depth = 4;
  request.options.of<VirtualLightOptions>() = {.count = 16, .distance = distance};
  return request;
}

// Inside a ball of radius 1, the cosines at both ends over the squared distance are the same for
// all pairs of points, so uniform light arrives from uniform places, D^2 / 4 of them within D. A
// bound there takes D^2 / 8 of what virtual lights bring, and nothing of emitted and direct light.
TEST(Vpl, CaveIsAsBrightAsItsSeriesLessWhatTheBoundTakes) {
  for (const float distance : {0.0f, 0.4f, 0.8f}) {
    for (const std::uint32_t depth : {1u, 2u, 5u}) {
      SCOPED_TRACE(std::to_string(distance) + ", depth " + std::to_string(depth));
      JobRequest request = Request(16, 16, 64, distance);
      request.max_depth = depth;
      const Image picture = Render(ShiningCave(), request);
      for (int c = 0; c < 3; ++c) {
        const double seen = CaveRadiance(c, 1);
        const double kept = 1 - double(distance) * double(distance) / 8;
        const double expected = seen + kept * (CaveRadiance(c, depth) - seen);
        EXPECT_NEAR(MeanOf(picture, std::size_t(c)) / expected, 1, 0.005) << "channel " << c;
      }
    }
  }
}

// A small mirror fills the view of a camera in the cave, so the mirror is one of the surfaces of a
// path, and lights of the longest light paths do not count.
TEST(Vpl, VisibleMirrorsCountAsSurfaces) {
  Scene scene = ShiningCave();
  scene.materials.push_back({.bsdf = BsdfKind::kMirror, .reflectance = glm::vec3(1)});
  Mesh mirror = Facetted(Quad(0.03f));
  FlipOrientation(mirror);
  Place(scene, mirror, std::uint32_t(scene.materials.size() - 1), {0, 0.02f, 0});
  scene.camera = LookAtCamera({0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 60, false);
  for (const std::uint32_t depth : {3u, 4u}) {
    JobRequest request = Request(16, 16, 64, 0);
    request.max_depth = depth;
    const Image picture = Render(scene, request);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(MeanOf(picture, std::size_t(c)) / CaveRadiance(c, depth - 1), 1, 0.01)
          << "depth " << depth << ", channel " << c;
    }
  }
}

// Without a bound near lights are unbiased, of every BSDF that has a density, and over mirrors and
// glass that are seen; the camera sees no light that mirrors throw on the floor.
TEST(Vpl, WithoutABoundMatchesPathTracing) {
  struct Row {
    BsdfKind bsdf;
    int lights;
  };
  constexpr Row kRows[] = {{BsdfKind::kLambert, kLamp},
                           {BsdfKind::kLambert, kEnvironment | kPoint},
                           {BsdfKind::kConductor, kLamp | kEnvironment},
                           {BsdfKind::kDiffuseTransmission, kBall}};
  for (const Row& row : kRows) {
    SCOPED_TRACE(std::to_string(std::uint32_t(row.bsdf)));
    const Scene scene = MattRoom(Of(row.bsdf, 0.5f), row.lights);
    JobRequest request = Request(15, 9, 48, 0);
    const RenderJob job(scene, request);
    const PictureEstimate lights = MeanOfBlocks(EstimateFromEngine(job, 8, 100), 3);
    request.integrator = Integrator::kPath;
    request.samples_per_pixel = 192;
    const PictureEstimate paths =
        MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), 8, 200), 3);
    EXPECT_TRUE(SamePicture(lights, paths, SidakLevel(std::size(kRows))));
  }
}

// The same lights and the same samples, so a bound can only take light away.
TEST(Vpl, BoundDarkensCornersAndBrightensNothing) {
  const Scene scene = MattRoom(Of(BsdfKind::kLambert), kLamp);
  const Image free = Render(scene, Request(32, 24, 16, 0));
  const Image narrow = Render(scene, Request(32, 24, 16, 0.2f));
  const Image wide = Render(scene, Request(32, 24, 16, 0.6f));
  const Image chosen = Render(scene, Request(32, 24, 16, -1));
  for (std::size_t i = 0; i < free.rgb.size(); ++i) {
    ASSERT_LE(narrow.rgb[i], free.rgb[i]);
    ASSERT_LE(wide.rgb[i], narrow.rgb[i]);
    ASSERT_LE(chosen.rgb[i], free.rgb[i]);
  }
  for (const std::size_t c : {0u, 1u, 2u}) {
    EXPECT_LT(MeanOf(wide, c), 0.995 * MeanOf(free, c));
    EXPECT_LT(MeanOf(chosen, c), MeanOf(free, c));
    EXPECT_GT(MeanOf(chosen, c), 0.95 * MeanOf(free, c));
  }
}

TEST(Vpl, PartsOfAFilmEqualTheWhole) {
  const Scene scene = MattRoom(Of(BsdfKind::kMirror), kLamp | kEnvironment);
  JobRequest request = Request(37, 29, 3, -1);
  request.options.of<GuideOptions>().guide = true;
  const Image whole = Render(scene, request);
  request.crop = CropWindow{9, 7, 12, 9};
  request.options.threads = 1, request.options.wave = 64;
  const Image part = Render(scene, request);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 12; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_EQ(part.Pixel(x, y)[c], whole.Pixel(x + 9, y + 7)[c]);
    }
  }
}

}  // namespace
}  // namespace skywave
