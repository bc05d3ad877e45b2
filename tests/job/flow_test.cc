// Tests optical flow: the layers of animated files against motions worked out by hand.
#include "wavefront/film/flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "base/error.h"
#include "image/image.h"
#include "job/job.h"
#include "tests/support/film_layers.h"
#include "tests/support/gltf_document.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr int kSize = 40;
// Of a second, which is a frame.
const glm::dvec3 kStep = {0.4, 0.2, -0.3}, kCameraStep = {0.1, -0.05, 0.05};
constexpr double kTurn = 0.2;

// The triangle is in a node that moves by kStep and turns about z by kTurn, and once more in one
// that rests; so are two of the camera's, which moves by kCameraStep.
GltfDocument MovingScene() {
  GltfDocument document = TriangleDocument();
  const int times = document.Add<float>({0, 4}, "SCALAR");
  const auto moves = [&](const glm::dvec3& from, const glm::dvec3& step) {
    std::vector<float> keys;
    for (const double time : {0.0, 4.0}) {
      for (int axis = 0; axis < 3; ++axis) keys.push_back(float(from[axis] + time * step[axis]));
    }
    return document.Add<float>(keys, "VEC3");
  };
  document.Animate(0, 0, "translation", times, moves({5, 0, 0}, kStep));
  document.Animate(
      0, 1, "rotation", times,
      document.Add<float>(
          {0, 0, 0, 1, 0, 0, std::sin(2 * float(kTurn)), std::cos(2 * float(kTurn))}, "VEC4"));
  document.Animate(0, 2, "translation", times, moves({5.25, 0.25, 4}, kCameraStep));
  document.json["nodes"][4] = {{"mesh", 0}, {"translation", {4, -1, 0.5}}};
  return document;
}

// Returns the place on the film of a point of the world, y down.
glm::dvec2 OnFilm(const glm::dvec3& point, double time) {
  const glm::dvec3 seen = point - (glm::dvec3(5.25, 0.25, 4) + time * kCameraStep);
  const double scale = kSize / 2.0 / std::tan(0.5) / -seen.z;
  return {kSize / 2.0 + scale * seen.x, kSize / 2.0 - scale * seen.y};
}

// Returns where a point that the moving node has at a time `from` is at `to`.
glm::dvec3 Moved(const glm::dvec3& point, double from, double to) {
  const glm::dvec3 local = point - glm::dvec3(5, 0, 0) - from * kStep;
  const double angle = kTurn * (to - from), c = std::cos(angle), s = std::sin(angle);
  return glm::dvec3(5, 0, 0) + to * kStep +
         glm::dvec3(c * local.x - s * local.y, s * local.x + c * local.y, local.z);
}

class Flow : public testing::Test {
 protected:
  JobRequest RequestOf(const GltfDocument& document) const {
    JobRequest request;
    request.scene = folder_.Write("a.gltf", document.text());
    request.environment.path = folder_.Path("white.pfm");
    Image white(4, 2);
    std::fill(white.rgb.begin(), white.rgb.end(), 1.0f);
    WritePfm(request.environment.path, white);
    request.width = request.height = kSize;
    request.samples_per_pixel = 1;
    request.read.frame = 1, request.read.fps = 1;
    request.options.aovs = ParseAovs("flow,flow-back,position,object-id").value();
    return request;
  }
  std::string Refusal(const JobRequest& request) const {
    try {
      const RenderJob job(request);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(Flow, IsTheMotionOfNodesAndCamera) {
  for (const InstanceUse use : {InstanceUse::kCopy, InstanceUse::kShare}) {
    JobRequest request = RequestOf(MovingScene());
    request.read.instances = use;
    const Layers layers = Resolve(RenderJob(request));
    int moving = 0, resting = 0;
    for (std::size_t i = 0; i < kSize * kSize; ++i) {
      const bool hit = layers.at("object-id.V")[i] > 0;
      ASSERT_EQ(layers.at("flow.A")[i], hit ? 1 : 0) << i;
      if (!hit) {
        ASSERT_EQ(layers.at("flow.X")[i], 0) << i;
        continue;
      }
      const glm::dvec3 point(layers.at("position.X")[i], layers.at("position.Y")[i],
                             layers.at("position.Z")[i]);
      const bool moves = std::abs(point.z + 0.3) < 0.01;  // at frame 1
      (moves ? moving : resting) += 1;
      for (const auto& [layer, frame] : {std::pair("flow", 2.0), {"flow-back", 0.0}}) {
        const glm::dvec3 then = moves ? Moved(point, 1, frame) : point;
        const glm::dvec2 expected = OnFilm(then, frame) - OnFilm(point, 1);
        ASSERT_NEAR(layers.at(std::string(layer) + ".X")[i], expected.x, 1e-4) << layer << i;
        ASSERT_NEAR(layers.at(std::string(layer) + ".Y")[i], expected.y, 1e-4) << layer << i;
      }
    }
    EXPECT_GT(moving, 20);
    EXPECT_GT(resting, 20);
  }
}

TEST_F(Flow, OfAGroundThatRestsIsNothing) {
  JobRequest request = RequestOf(MovingScene());
  request.ground = Ground::kGrey;
  request.camera.eye = glm::vec3(5, 3, 5);
  request.camera.target = glm::vec3(5, -1, 0);
  const Layers layers = Resolve(RenderJob(request));
  const float ground =
      *std::max_element(layers.at("object-id.V").begin(), layers.at("object-id.V").end());
  int seen = 0;
  for (std::size_t i = 0; i < kSize * kSize; ++i) {
    if (layers.at("object-id.V")[i] != ground) continue;
    ++seen;
    for (const std::string layer : {"flow", "flow-back"}) {
      ASSERT_EQ(layers.at(layer + ".A")[i], 1) << i;
      ASSERT_EQ(layers.at(layer + ".X")[i], 0) << i;
      ASSERT_EQ(layers.at(layer + ".Y")[i], 0) << i;
    }
  }
  EXPECT_GT(seen, 100);
}

// On a turntable the camera turns about a scene that rests: where a point is in the next picture is
// where that picture has it.
TEST_F(Flow, OfATurntableLeadsToThePictureThatIsTurned) {
  JobRequest request;
  request.scene = "spheres";
  request.width = request.height = 64;
  request.samples_per_pixel = 1;
  request.camera.orbit_step = 10;
  request.camera.orbit_degrees = 10.0f;
  request.options.aovs = ParseAovs("flow,flow-back,position").value();
  const Layers here = Resolve(RenderJob(request));
  for (const auto& [layer, degrees] : {std::pair("flow", 20.0f), {"flow-back", 0.0f}}) {
    request.camera.orbit_degrees = degrees;
    const Layers there = Resolve(RenderJob(request));
    int known = 0, found = 0, unmoved = 0;
    const auto is_near = [&](std::size_t i, std::size_t j) {
      double apart = 0;
      for (const char* const axis : {"position.X", "position.Y", "position.Z"}) {
        apart += std::pow(double(here.at(axis)[i]) - double(there.at(axis)[j]), 2);
      }
      return apart < 0.15 * 0.15;
    };
    for (std::size_t i = 0; i < 64 * 64; ++i) {
      if (here.at(std::string(layer) + ".A")[i] == 0) continue;
      const double x = double(i % 64) + 0.5 + double(here.at(std::string(layer) + ".X")[i]);
      const double y = double(i / 64) + 0.5 + double(here.at(std::string(layer) + ".Y")[i]);
      if (x < 0 || y < 0 || x >= 64 || y >= 64) continue;
      ++known, unmoved += is_near(i, i), found += is_near(i, std::size_t(y) * 64 + std::size_t(x));
    }
    EXPECT_GT(known, 1500) << layer;
    // The others are hidden there, or at edges and slants.
    EXPECT_GT(found, 0.7 * known) << layer;
    EXPECT_LT(unmoved, 0.35 * known) << layer;
  }
}

// The scene is the same at this moment, and the next frame is not.
TEST_F(Flow, TellsFilmsOfOtherFrameLengthsApart) {
  const auto hash = [&](double frame, double fps, const char* aovs) {
    JobRequest request = RequestOf(MovingScene());
    request.read.frame = frame, request.read.fps = fps;
    request.options.aovs = ParseAovs(aovs).value();
    return RenderJob(request).scene_hash();
  };
  EXPECT_EQ(hash(2, 2, "position"), hash(1, 1, "position"));
  EXPECT_NE(hash(2, 2, "flow"), hash(1, 1, "flow"));
  EXPECT_EQ(hash(1, 1, "flow"), hash(1, 1, "flow"));
}

TEST_F(Flow, ChangesNoBitOfThePicture) {
  JobRequest request = RequestOf(MovingScene());
  const Film with = Render(RenderJob(request));
  request.options.aovs = 0;
  const Film without = Render(RenderJob(request));
  EXPECT_TRUE(std::equal(with.sums().begin(), with.sums().end(), without.sums().begin(),
                         without.sums().end()));
}

TEST_F(Flow, WithoutMotionIsRefused) {
  JobRequest request = RequestOf(MovingScene());
  EXPECT_EQ(Refusal(request), "");
  request.camera.kind = CameraKind::kLatLong;
  EXPECT_NE(Refusal(request).find("perspective or an orthographic"), std::string::npos);
  request = RequestOf(MovingScene());
  request.read.frame.reset();
  EXPECT_NE(Refusal(request).find("needs `frame`"), std::string::npos);
  request = RequestOf(TriangleDocument());
  EXPECT_NE(Refusal(request).find("an animation"), std::string::npos);
}

TEST(PlaceOnFilm, IsWhereTheRayOfAPixelBegins) {
  CameraView camera = {.origin = {1, 2, 3},
                       .corner = {-0.5f, 0.25f, -1},
                       .right = {0.1f, 0.02f, 0},
                       .down = {0.01f, -0.1f, 0.03f},
                       .forward = {0.2f, 0.1f, -1}};
  for (const CameraKind kind : {CameraKind::kPerspective, CameraKind::kOrthographic}) {
    camera.kind = kind;
    const auto point = [&](double x, double y, double t) {
      glm::dvec3 p;
      for (int i = 0; i < 3; ++i) {
        const double film = camera.corner[i] + x * camera.right[i] + y * camera.down[i];
        p[i] = kind == CameraKind::kPerspective ? camera.origin[i] + t * film
                                                : film + t * camera.forward[i];
      }
      return p;
    };
    for (const double t : {0.5, 7.0}) {
      const auto at = PlaceOnFilm(camera, point(3.25, -1.5, t));
      ASSERT_TRUE(at);
      EXPECT_NEAR(at->x, 3.25, 1e-9);
      EXPECT_NEAR(at->y, -1.5, 1e-9);
    }
    EXPECT_EQ(PlaceOnFilm(camera, point(3.25, -1.5, -1)).has_value(),
              kind == CameraKind::kOrthographic);
  }
}

}  // namespace
}  // namespace skywave
