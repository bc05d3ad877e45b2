// Tests what the maps of photons hold: the flux of the lights, each photon once, divided by the
// surfaces that it has hit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "scene/shapes/mesh.h"
#include "tests/support/photon_maps.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/shining_cave.h"
#include "wavefront/records/photon_map.h"

namespace skywave {
namespace {

// Returns the flux of all photons that have hit `depth` surfaces; 0 stands for all photons.
double FluxOf(const PhotonMap& map, int channel, std::uint32_t depth) {
  const PhotonColumns& photons = map.view().photons;
  const float* const flux[3] = {photons.r, photons.g, photons.b};
  double sum = 0;
  for (std::uint32_t i = 0; i < map.size(); ++i) {
    if (depth == 0 || photons.depth[i] == depth) sum += double(flux[channel][i]);
  }
  return sum;
}

// In a closed cave, no light is lost: the flux of photons at their n-th surface is the flux that
// leaves the lights times the albedo of each previous surface.
TEST(PhotonMaps, MapsHoldTheFluxOfTheLights) {
  JobRequest request = PhotonRequest(8, 8, 1, 4);
  request.options.of<PhotonOptions>().gather = 1;  // direct light too
  const RenderJob job(ShiningCave(), request);
  const PhotonMaps maps = MapsOf(job);
  EXPECT_GE(maps.indirect.size(), request.options.of<PhotonOptions>().indirect);
  EXPECT_LT(maps.indirect.size(), request.options.of<PhotonOptions>().indirect + 4);
  double area = 0;
  const Geometry& geometry = job.geometry();
  for (std::size_t i = 0; i < geometry.triangle_count(); ++i) {
    const glm::vec3 a = geometry.Corner(i, 0), b = geometry.Corner(i, 1), c = geometry.Corner(i, 2);
    area += 0.5 * double(glm::length(glm::cross(b - a, c - a)));
  }
  for (int c = 0; c < 3; ++c) {
    const double emitted = std::numbers::pi * double(kCaveEmission) * area;
    for (std::uint32_t depth = 1; depth <= 4; ++depth) {
      const double expected = emitted * std::pow(double(kCaveAlbedo[c]), depth - 1);
      EXPECT_NEAR(FluxOf(maps.indirect, c, depth) / expected, 1, depth < 4 ? 0.002 : 0.04)
          << "channel " << c << ", depth " << depth;
    }
  }
}

// Behind glass, only caustics are stored, and nothing that light samples find.
TEST(PhotonMaps, MapsAreDividedByTheSurfacesThatPhotonsHit) {
  Scene scene = UnderGlass();
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  JobRequest request = PhotonRequest(8, 8, 1, 6);
  for (const std::uint32_t gather : {0u, 1u}) {
    request.options.of<PhotonOptions>().gather = gather;
    const PhotonMaps maps = MapsOf(RenderJob(scene, request));
    ASSERT_GT(maps.caustic.size(), 1000u);
    EXPECT_EQ(FluxOf(maps.caustic, 0, 1), 0) << "direct light is no caustic";
    EXPECT_GT(FluxOf(maps.caustic, 0, 3), 0) << "in and out of the ball";
    if (gather == 0) {
      EXPECT_EQ(FluxOf(maps.indirect, 0, 1), 0);
      // The floor is flat, so between two of its points there must be glass.
      EXPECT_EQ(FluxOf(maps.indirect, 0, 2), 0);
    } else {
      EXPECT_GT(FluxOf(maps.indirect, 0, 1), 0);
    }
  }
}

// Returns where the photons of a map came from and arrived, which identifies light paths.
std::set<std::array<float, 3>> PlacesOf(const PhotonMap& map) {
  const PointTreeView tree = map.view().tree;
  std::set<std::array<float, 3>> places;
  for (std::uint32_t i = 0; i < map.size(); ++i) places.insert({tree.x[i], tree.y[i], tree.z[i]});
  return places;
}

std::size_t InBoth(const std::set<std::array<float, 3>>& a,
                   const std::set<std::array<float, 3>>& b) {
  return std::size_t(std::count_if(a.begin(), a.end(), [&](const auto& p) { return b.count(p); }));
}

// Both maps are looked up at every surface, so a photon in both would count twice.
TEST(PhotonMaps, EachPhotonIsInOneMapOnly) {
  Scene scene = UnderGlass();
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  JobRequest request = PhotonRequest(8, 8, 1, 6);
  request.options.of<PhotonOptions>().gather = 0;
  const PhotonMaps maps = MapsOf(RenderJob(scene, request));
  const auto caustic = PlacesOf(maps.caustic), indirect = PlacesOf(maps.indirect);
  ASSERT_GT(caustic.size(), 1000u);
  ASSERT_GT(indirect.size(), 1000u);
  EXPECT_EQ(InBoth(caustic, indirect), 0u);
}

// The mean of all passes only converges if each of them has new photons.
TEST(PhotonMaps, PassesHavePhotonsOfTheirOwn) {
  JobRequest request = PhotonRequest(8, 8, 4, 3);
  request.options.of<PhotonOptions>().indirect = 2000;
  request.options.of<PhotonOptions>().passes = 4;
  const RenderJob job(ShiningCave(), request);
  const FrameView frame = job.frame();
  WorkerPool pool = TwoThreads(frame);
  std::set<std::array<float, 3>> before;
  pool.Run([&] {
    for (const PhotonPass& pass : PhotonPasses(frame.options)) {
      const auto places = PlacesOf(TracePhotons(frame, pass, pool).indirect);
      EXPECT_GE(places.size(), 1900u);
      EXPECT_EQ(InBoth(places, before), 0u) << "from sample " << pass.samples.first;
      before.insert(places.begin(), places.end());
    }
  });
}

}  // namespace
}  // namespace skywave
