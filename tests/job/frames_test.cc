// Tests what the number of a frame decides: the file of a map that moves, the noise, and which
// parts frames have in common.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "job/job.h"
#include "job/map_sequence.h"
#include "tests/support/gltf_document.h"
#include "tests/support/render_scenes.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

class Frames : public testing::Test {
 protected:
  JobRequest MapAt(const std::string& name, double frame) const {
    JobRequest request;
    request.environment.path = folder_.Path(name);
    request.read.frame = frame;
    return request;
  }
  // Expects the options and `part` in the message.
  static void ExpectRefused(const JobRequest& request, const std::string& part) {
    try {
      MapFile(request);
      ADD_FAILURE() << "not refused: " << part;
    } catch (const OptionError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
  TemporaryFolder folder_;
};

TEST_F(Frames, NumberTheFilesOfAMapThatMoves) {
  EXPECT_EQ(MapFile(MapAt("sky_####.exr", 7)), folder_.Path("sky_0007.exr"));
  EXPECT_EQ(MapFile(MapAt("sky_#.exr", 1234)), folder_.Path("sky_1234.exr"));
  EXPECT_EQ(MapFile(MapAt("##", 0)), folder_.Path("00"));
  EXPECT_EQ(MapFile(MapAt("take#2_###.hdr", 5)), folder_.Path("take#2_005.hdr"));
  EXPECT_EQ(MapFile(MapAt("take#2/a.hdr", 5)), folder_.Path("take#2/a.hdr"));
  EXPECT_EQ(MapFile(MapAt("sky_####.exr", -3)), folder_.Path("sky_-003.exr"));
  folder_.Write("sky_##.exr", "a file of that very name");
  EXPECT_EQ(MapFile(MapAt("sky_##.exr", 7)), folder_.Path("sky_##.exr"));

  ExpectRefused(MapAt("sky_####.exr", 0.5), "frame 0.5");
  JobRequest without = MapAt("sky_####.exr", 0);
  without.read.frame.reset();
  ExpectRefused(without, "`frame N`");
}

TEST_F(Frames, NumberTheFilesOfLightsThatMove) {
  const auto at = [&](const char* strategy, std::optional<double> frame) {
    JobRequest request;
    request.strategy = strategy, request.read.frame = frame;
    return StrategyOfFrame(request);
  };
  EXPECT_EQ(at("presampled:file=sets/set_####.json,mode=fixed", 7),
            "presampled:file=sets/set_0007.json,mode=fixed");
  EXPECT_EQ(at("hybrid:file=set_##.json", 12.75), "hybrid:file=set_12.json");
  EXPECT_EQ(at("importance:compensate=1", 7), "importance:compensate=1");
  EXPECT_EQ(at("hybrid:file=set_##.json", std::nullopt), "hybrid:file=set_##.json");
}

std::vector<std::uint64_t> Sums(const JobRequest& request) {
  const RenderJob job(request);
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  return {film.sums().begin(), film.sums().end()};
}

// The strategy of a frame is that of its file.
TEST_F(Frames, AreLitByTheLightsOfTheirFiles) {
  for (const int frame : {1, 2}) {
    folder_.Write(fmt::format("set_{:02}.json", frame),
                  fmt::format(R"({{"samples": [{{"uv": [0.5, {}]}}]}})", 0.2 * frame));
  }
  JobRequest request = SmallRequest(16, 12, 2);
  request.scene = "spheres";
  request.coherent_noise = true;
  const auto by = [&](const char* name, double frame) {
    request.read.frame = frame;
    request.strategy = "presampled:mode=fixed,file=" + folder_.Path(name);
    return Sums(request);
  };
  EXPECT_EQ(by("set_##.json", 1), by("set_01.json", 1));
  EXPECT_EQ(by("set_##.json", 2), by("set_02.json", 2));
  EXPECT_NE(by("set_##.json", 2), by("set_01.json", 2));
}

TEST_F(Frames, HaveNoiseOfTheirOwnUnlessItIsToBeCoherent) {
  JobRequest request = SmallRequest(16, 12, 2);
  request.scene = "spheres";
  const auto at = [&](double frame, bool coherent, std::uint32_t seed = 0) {
    JobRequest changed = request;
    changed.read.frame = frame;
    changed.coherent_noise = coherent;
    changed.options.seed = seed;
    return Sums(changed);
  };
  const std::vector<std::uint64_t> without = Sums(request), first = at(1, false);
  EXPECT_FALSE(first == without);
  EXPECT_FALSE(first == at(2, false));
  EXPECT_FALSE(first == at(1.5, false));
  EXPECT_FALSE(first == at(1, false, 5)) << "the seed still counts";
  EXPECT_TRUE(first == at(1, false));
  EXPECT_TRUE(at(0.0, false) == at(-0.0, false));
  EXPECT_TRUE(at(1, true) == without);
  EXPECT_TRUE(at(2, true) == without);
}

// A triangle that is one unit wide at frame 0 rises and grows.
GltfDocument RisingTriangle() {
  GltfDocument document = TriangleDocument();
  document.json["scenes"] = {{{"nodes", {0}}}};  // without cameras
  const int times = document.Add<float>({0, 1}, "SCALAR");
  document.Animate(0, 0, "translation", times, document.Add<float>({0, 0, 0, 0, 7, 0}, "VEC3"));
  document.Animate(0, 0, "scale", times, document.Add<float>({1, 1, 1, 3, 3, 3}, "VEC3"));
  return document;
}

TEST_F(Frames, HaveTheGroundAndTheCameraOfFrame0) {
  JobRequest request = SmallRequest(16, 12, 1);
  request.scene = folder_.Write("a.gltf", RisingTriangle().text());
  request.environment.path = folder_.Path("white.pfm");
  Image white(4, 2);
  std::fill(white.rgb.begin(), white.rgb.end(), 1.0f);
  WritePfm(request.environment.path, white);
  request.ground = Ground::kGrey;
  request.read.fps = 1;
  const auto place = [&](double frame) {
    request.read.frame = frame;
    const RenderJob job(request);
    const auto triangles = job.geometry().triangle_tables();
    const std::size_t last = 3 * job.geometry().vertex_count();
    std::vector<float> ground(triangles.positions + last - 12, triangles.positions + last);
    const CameraView camera = job.frame().camera;
    ground.insert(ground.end(), camera.origin, camera.origin + 3);
    ground.insert(ground.end(), camera.right, camera.right + 3);
    return ground;
  };
  const std::vector<float> first = place(0);
  EXPECT_EQ(place(0.5), first);
  EXPECT_EQ(place(1), first);
  EXPECT_LT(first[1], 0) << "below the triangle of frame 0";
}

TEST_F(Frames, OfAStillSceneHaveOneSceneAndOneTree) {
  JobRequest request = SmallRequest(16, 12, 1);
  request.scene = "spheres";
  request.read.frame = 1;
  JobCache cache(std::uint64_t{1} << 40);
  const RenderJob first(request, &cache);
  request.read.frame = 2;
  const RenderJob second(request, &cache);
  EXPECT_EQ(&first.geometry(), &second.geometry());
  ASSERT_FALSE(second.notes().empty());
  EXPECT_NE(second.notes().front().find("no animation"), std::string::npos);
}

}  // namespace
}  // namespace skywave
