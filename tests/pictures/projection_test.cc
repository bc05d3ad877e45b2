// Tests pictures of a place that are projected onto it, against lookups that are written here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "base/files.h"
#include "job/merge_films.h"
#include "job/picture.h"
#include "job/session.h"
#include "tests/support/film_layers.h"
#include "tests/support/made_image.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"
#include "tests/support/targets.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr float kHeight = 1.5f;
constexpr int kWidth = 40, kRows = 30;
const glm::dvec3 kCenter(0, kHeight, 0);  // of the map: the scene's middle is at the origin

// A smooth map, darker below: grounds are not brighter than white.
Image SmoothMap() {
  return MadeImage(256, 128, [](int x, int y) {
    const double theta = M_PI * (y + 0.5) / 128, phi = 2 * M_PI * (x + 0.5) / 256;
    const double below = y >= 64 ? 0.25 : 1;
    return glm::vec3(below * (1 + 0.5 * std::cos(phi)), below * (0.8 + 0.4 * std::sin(2 * phi)),
                     below * (0.7 + 0.3 * std::cos(3 * theta)));
  });
}

// Returns the map in a direction of the world (y up, the middle of the map towards -z, its right
// half to the right of that), between the centres of its pixels.
glm::dvec3 LookUp(const Image& map, const glm::dvec3& direction) {
  const glm::dvec3 d = glm::normalize(direction);
  const double u = 0.5 + std::atan2(d.x, -d.z) / (2 * M_PI), v = std::acos(d.y) / M_PI;
  const double x = u * map.width - 0.5, y = v * map.height - 0.5;
  glm::dvec3 sum(0);
  for (const int i : {0, 1}) {
    for (const int j : {0, 1}) {
      const int column = int(std::floor(x)) + i, row = int(std::floor(y)) + j;
      const double weight = (1 - std::abs(x - column)) * (1 - std::abs(y - row));
      const float* const rgb =
          map.Pixel((column + map.width) % map.width, std::clamp(row, 0, map.height - 1));
      sum += weight * glm::dvec3(rgb[0], rgb[1], rgb[2]);
    }
  }
  return sum;
}

// Returns the radiance of a white ground under the map.
glm::dvec3 WhiteGround(const Image& map) {
  glm::dvec3 irradiance(0);
  for (int y = 0; y < map.height / 2; ++y) {
    const double from = M_PI * y / map.height, to = M_PI * (y + 1) / map.height;
    const double weight =
        (std::sin(to) * std::sin(to) - std::sin(from) * std::sin(from)) * M_PI / map.width;
    for (int x = 0; x < map.width; ++x) {
      const float* const rgb = map.Pixel(x, y);
      irradiance += weight * glm::dvec3(rgb[0], rgb[1], rgb[2]);
    }
  }
  return irradiance / M_PI;
}

// A floor, a catcher, around the origin.
Scene FloorScene() {
  Scene scene;
  Place(scene, Quad(20), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  SetLight(scene, SmoothMap());
  scene.camera = LookAtCamera({1, 2, 4}, {0, 0.5f, 0}, {0, 1, 0}, 50, false);
  return scene;
}

// Samples are in the middle of their pixels.
JobRequest Request(std::uint32_t samples = 1) {
  JobRequest request = SmallRequest(kWidth, kRows, samples);
  request.catchers = {"floor"};
  request.dome = DomeRequest{.height = kHeight};
  request.filter = PixelFilter::kBox;
  request.options.filter_radius = 1e-5f;
  return request;
}

// Returns the direction of the ray through the middle of a pixel.
glm::dvec3 RayOf(const CameraView& camera, int x, int y) {
  glm::dvec3 ray;
  for (int axis = 0; axis < 3; ++axis) {
    ray[axis] = double(camera.corner[axis]) + (x + 0.5) * double(camera.right[axis]) +
                (y + 0.5) * double(camera.down[axis]);
  }
  return glm::normalize(ray);
}

glm::dvec3 At(const Layers& layers, const std::string& name, const char* channels, std::size_t i) {
  glm::dvec3 value;
  for (int c = 0; c < 3; ++c) value[c] = double(layers.at(name + "." + channels[c])[i]);
  return value;
}

void ExpectNear(const glm::dvec3& value, const glm::dvec3& expected, double relative,
                std::size_t i) {
  for (int c = 0; c < 3; ++c) {
    ASSERT_NEAR(value[c], expected[c], relative * (0.05 + expected[c])) << i << " " << c;
  }
}

TEST(Domes, TheGroundShowsWhatTheMapSawOfIt) {
  const Scene scene = FloorScene();
  const Image map = SmoothMap();
  const glm::dvec3 white = WhiteGround(map);
  JobRequest request = Request();
  request.options.aovs = *ParseAovs("albedo,position");
  const RenderJob job(scene, request);
  std::vector<float> first;
  for (const std::int64_t target : TestedTargets()) {
    const TargetScope scope(target);
    const Layers layers = Resolve(job);
    int on_floor = 0, above = 0;
    for (std::size_t i = 0; i < std::size_t(kWidth * kRows); ++i) {
      const glm::dvec3 seen = At(layers, "backdrop", "RGB", i);
      const glm::dvec3 point = At(layers, "position", "XYZ", i);
      const bool is_floor = point != glm::dvec3(0);
      const glm::dvec3 ray = RayOf(job.frame().camera, int(i) % kWidth, int(i) / kWidth);
      // The ground goes on beyond the floor.
      const glm::dvec3 from_center = glm::dvec3(1, 2, 4) - kCenter;
      const double t = (from_center.y + double(kHeight)) / -ray.y;
      ExpectNear(seen, LookUp(map, ray.y < 0 ? from_center + t * ray : ray), 2e-3, i);
      if (is_floor) {
        ExpectNear(seen, LookUp(map, point - kCenter), 2e-3, i);
        ExpectNear(At(layers, "albedo", "RGB", i), seen / white, 6e-3, i);
      }
      on_floor += is_floor, above += ray.y > 0.02;
    }
    EXPECT_GT(on_floor, 300);
    EXPECT_GT(above, 100);
    const std::vector<float>& green = layers.at("albedo.G");
    if (first.empty()) first = green;
    EXPECT_EQ(green, first) << hwy::TargetName(target);
  }
}

// The first of the ground and the sphere that a ray meets, found by small steps.
glm::dvec3 MeetsDome(const glm::dvec3& eye, const glm::dvec3& ray, double radius) {
  const auto outside = [&](double t) {
    const glm::dvec3 p = eye + t * ray;
    return p.y < 0 || glm::length(p - kCenter) > radius;
  };
  double t = 0;
  while (!outside(t)) t += 0.01;
  double inside = t - 0.01;
  for (int i = 0; i < 50; ++i) (outside((inside + t) / 2) ? t : inside) = (inside + t) / 2;
  return eye + t * ray;
}

TEST(Domes, BeyondTheGroundTheMapIsOnASphere) {
  const Scene scene = FloorScene();
  const Image map = SmoothMap();
  JobRequest request = Request();
  request.dome->radius = 6;
  const RenderJob job(scene, request);
  const Layers layers = Resolve(job);
  int ground = 0, sphere = 0;
  for (std::size_t i = 0; i < std::size_t(kWidth * kRows); ++i) {
    const glm::dvec3 ray = RayOf(job.frame().camera, int(i) % kWidth, int(i) / kWidth);
    const glm::dvec3 point = MeetsDome({1, 2, 4}, ray, 6);
    ExpectNear(At(layers, "backdrop", "RGB", i), LookUp(map, point - kCenter), 2e-3, i);
    (point.y < 1e-2 ? ground : sphere) += 1;
  }
  EXPECT_GT(ground, 100);
  EXPECT_GT(sphere, 300);
}

// An upright mirror doubles the sky above the floor, which is the same on both sides, so it takes
// no light away: in it the floor is as bright as the map shows it.
TEST(Domes, MirrorsShowTheGroundWithTheColoursOfTheMap) {
  const Image map = MadeImage(128, 64, [](int x, int y) {
    const double phi = 2 * M_PI * (x + 0.5) / 128;
    return y < 32 ? glm::vec3(1) : glm::vec3(0.5 + 0.3 * std::cos(phi), 0.4, 0.2);
  });
  Scene scene = FloorScene();
  SetLight(scene, map);
  const std::uint32_t mirror = AddMirror(scene, 1);
  Mesh wall;
  wall.positions = {{-3, 0, -2}, {3, 0, -2}, {3, 4, -2}, {-3, 4, -2}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  wall.material = mirror;
  const Bounds before = SceneBounds(scene, "test");
  scene.meshes.push_back(wall);
  scene.camera = LookAtCamera({0, 2, 3}, {0, 0.4f, -2}, {0, 1, 0}, 25, false);
  JobRequest request = Request(1024);
  request.width = 12, request.height = 8;
  const RenderJob job(scene, request);
  const Image image = Render(job).Resolve(1024);
  const Bounds bounds = SceneBounds(scene, "test");
  ASSERT_EQ(bounds.low.x, before.low.x);
  int seen = 0;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 12; ++x) {
      const glm::dvec3 ray = RayOf(job.frame().camera, x, y);
      const double to_wall = (-2 - 3.0) / ray.z;
      const glm::dvec3 on_wall = glm::dvec3(0, 2, 3) + to_wall * ray;
      if (on_wall.y < 0.2 || std::abs(on_wall.x) > 2.5 || ray.y > -0.05) continue;
      const glm::dvec3 back(ray.x, ray.y, -ray.z);
      const glm::dvec3 point = on_wall - back * (on_wall.y / back.y);
      const glm::dvec3 expected = LookUp(map, point - kCenter);
      const float* const rgb = image.Pixel(x, y);
      ExpectNear({rgb[0], rgb[1], rgb[2]}, expected, 0.04, std::size_t(12 * y + x));
      ++seen;
    }
  }
  EXPECT_GT(seen, 30);
}

class ProjectedPhotographs : public testing::Test {
 protected:
  void SetUp() override {
    plate_ = MadeImage(kWidth, kRows, [](int x, int y) {
      return glm::vec3(0.1f + 0.01f * float(x), 0.05f + 0.012f * float(y),
                       0.2f + 0.002f * float(x + y));
    });
    WriteExr(folder_.Path("plate.exr"), plate_);
    std::vector<std::uint8_t> bytes;
    for (const float value : plate_.rgb) {
      bytes.push_back(std::uint8_t(std::lround(255 * std::min(value, 1.0f))));
    }
    WritePng(folder_.Path("plate.png"), kWidth, kRows, bytes);
  }

  JobRequest RequestOf(const std::string& plate) {
    JobRequest request = Request();
    request.dome.reset();
    request.backplate = folder_.Path(plate);
    request.project = Projected::kCamera;
    request.options.aovs = *ParseAovs("albedo,coverage,position");
    return request;
  }

  TemporaryFolder folder_;
  Image plate_;
};

// From the camera that took it the floor has the pixels of the photograph: those for screens as its
// colours, and radiance over that of a white floor.
TEST_F(ProjectedPhotographs, AreSeenFromTheirCamera) {
  const glm::dvec3 white = WhiteGround(SmoothMap());
  const Image screen = ReadTexture(folder_.Path("plate.png"), Encoding::kSrgb);
  for (const std::string plate : {"plate.exr", "plate.png"}) {
    const RenderJob job(FloorScene(), RequestOf(plate));
    const Layers layers = Resolve(job);
    int seen = 0;
    for (std::size_t i = 0; i < std::size_t(kWidth * kRows); ++i) {
      if (layers.at("coverage.V")[i] < 1) continue;
      ++seen;
      const float* const rgb = &(plate == "plate.png" ? screen : plate_).rgb[3 * i];
      const glm::dvec3 value(rgb[0], rgb[1], rgb[2]);
      const glm::dvec3 expected = plate == "plate.png" ? value : value / white;
      ExpectNear(At(layers, "albedo", "RGB", i), glm::min(expected, glm::dvec3(1)), 6e-3, i);
    }
    EXPECT_GT(seen, 300);
  }
}

// A mirror image of the camera's, below the floor, sees the same points from elsewhere; those that
// are beyond the photograph have the pixels of its border.
TEST_F(ProjectedPhotographs, LieOnTheFloorWhoeverSeesIt) {
  const RenderJob job(FloorScene(), RequestOf("plate.png"));
  const CameraView camera = job.frame().camera;
  Scene scene = FloorScene();
  scene.camera->kind = CameraKind::kPerspective;
  const Image screen = ReadTexture(folder_.Path("plate.png"), Encoding::kSrgb);
  // The place is the same; only the film shows another part of it, by a mirror in front.
  const std::uint32_t mirror = AddMirror(scene, 1);
  Mesh wall;
  wall.positions = {{-9, 0, -3}, {9, 0, -3}, {9, 9, -3}, {-9, 9, -3}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  wall.material = mirror;
  scene.meshes.push_back(wall);
  SetConstantLight(scene, 1);
  JobRequest request = RequestOf("plate.png");
  request.samples_per_pixel = 256;
  request.max_depth = 4;  // floors see the sky in the mirror
  const RenderJob mirrored(scene, request);
  const Image image = Render(mirrored).Resolve(256);
  int inside = 0, beyond = 0;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const glm::dvec3 eye(1, 2, 4), ray = RayOf(camera, x, y);
      const glm::dvec3 on_wall = eye + ray * ((-3 - eye.z) / ray.z);
      if (ray.y > -0.03 || on_wall.y < 0.1) continue;
      const glm::dvec3 point = on_wall + glm::dvec3(ray.x, ray.y, -ray.z) * (on_wall.y / -ray.y);
      // Its place on the photograph, by solving for the pixel.
      const auto vector = [](const float* v) { return glm::dvec3(v[0], v[1], v[2]); };
      const glm::dmat3 axes(vector(camera.right), vector(camera.down), vector(camera.corner));
      const glm::dvec3 p = glm::inverse(axes) * (point - eye);
      if (p.z < 0.1) continue;
      const double px = p.x / p.z, py = p.y / p.z;
      const int column = std::clamp(int(std::floor(px)), 0, kWidth - 1),
                row = std::clamp(int(std::floor(py)), 0, kRows - 1);
      const float* const rgb = screen.Pixel(column, row);
      const float* const seen = image.Pixel(x, y);
      // Under a white sky, of which the mirror takes nothing, radiance is reflectance.
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(seen[c], rgb[c], 0.03f + 0.05f * rgb[c]) << x << " " << y;
      (px >= 0 && py >= 0 && px < kWidth && py < kRows ? inside : beyond) += 1;
    }
  }
  EXPECT_GT(inside + beyond, 60);
  EXPECT_GT(beyond, 20);
}

// The PNG and the layer composite are the picture over the map on the ground, also when films of
// parts become one.
TEST(Domes, AreBehindThePictureOfMergedFilms) {
  TemporaryFolder folder;
  Scene scene = FloorScene();
  Place(scene, Sphere(0.5f), AddLambert(scene, "ball", {0.7f, 0.2f, 0.1f}), {0, 0.5f, 0});
  JobRequest request = Request(8);
  const auto film = [&](std::uint32_t first, std::uint32_t count, const std::string& file) {
    JobRequest part = request;
    const RenderJob job(scene, part);
    const PictureIdentity identity =
        IdentityOf(job, {.exposure = ExposureChoice{.stops = 0}}, true);
    RenderLimits limits;
    if (count < 8) limits.samples = SampleRange{first, first + count};
    const RenderedFilm rendered = RunSession(job, identity, {.limits = limits});
    WriteFilm(folder.Path(file), identity, job.options().aovs, rendered);
    return ResolvePicture(rendered.film, rendered.samples, job.options().aovs, identity,
                          rendered.part);
  };
  const Picture whole = film(0, 8, "whole.film");
  film(0, 3, "a.film"), film(3, 5, "b.film");
  const Picture merged =
      ResolveMerged(MergeFilms({.films = {folder.Path("a.film"), folder.Path("b.film")}}));
  ASSERT_FALSE(whole.composite.rgb.empty());
  EXPECT_EQ(merged.composite.rgb, whole.composite.rgb);
  const Layers layers = ByName(whole.layers);
  for (std::size_t i = 0; i < whole.alpha.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float behind = layers.at(std::string("backdrop.") + "RGB"[c])[i];
      const float expected = whole.image.rgb[3 * i + c] + (1 - whole.alpha[i]) * behind;
      ASSERT_FLOAT_EQ(whole.composite.rgb[3 * i + c], expected);
    }
  }
}

TEST(BadProjections, AreRefusedByName) {
  const Scene scene = FloorScene();
  const auto refused = [&](const auto& change, const std::string& word) {
    JobRequest request = Request();
    change(request);
    ExpectRefused(scene, request, word);
  };
  refused([](JobRequest& r) { r.project = Projected::kCamera; }, "backplate FILE");
  refused([](JobRequest& r) { r.dome.reset(), r.project = Projected::kDome; }, "dome HEIGHT");
  refused([](JobRequest& r) { r.catchers.clear(), r.project = Projected::kDome; }, "catcher");
  refused([](JobRequest& r) { r.background = Background::kMap; }, "background map");
  refused([](JobRequest& r) { r.catchers.clear(), r.integrator = Integrator::kVcm; }, "dome");
  refused([](JobRequest& r) { r.catchers.clear(), r.options.bsdf_samples = 2; }, "split");
  Scene dark = scene;
  dark.environments.clear();
  dark.lights = {SlantingSun()};
  ExpectRefused(dark, Request(), "env FILE");
}

TEST(Projections, SayWhereTheyAreNotRight) {
  const auto notes = [](const Scene& scene) {
    const RenderJob job(scene, Request());
    std::string all;
    for (const std::string& note : job.notes()) all += note + "\n";
    return all;
  };
  Scene scene = FloorScene();
  EXPECT_EQ(notes(scene).find("project"), std::string::npos) << notes(scene);
  scene.lights = {SlantingSun()};
  EXPECT_NE(notes(scene).find("lamps"), std::string::npos) << notes(scene);
  // Half of the directions below the horizon are brighter than white.
  SetLight(scene, MadeImage(64, 32, [](int x, int y) {
             return glm::vec3(y < 16 || x < 32 ? 0.5f : 2.0f);
           }));
  EXPECT_NE(notes(scene).find("50 % of the map below the horizon"), std::string::npos)
      << notes(scene);
}

}  // namespace
}  // namespace skywave
