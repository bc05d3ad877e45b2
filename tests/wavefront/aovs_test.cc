// Tests the layers of a picture: their values, and that these do not depend on the order of work.
#include "wavefront/film/aovs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/shapes.h"
#include "tests/support/film_layers.h"
#include "tests/support/painted_scene.h"
#include "tests/support/targets.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

std::vector<std::uint64_t> Sums(const Film& film) {
  return {film.sums().begin(), film.sums().end()};
}

// Half of the film sees a frontal wall of two squares, one of them at half the distance of the
// other; the other half sees the environment. A pixel is a tenth of a unit at distance 4.
Scene TwoWalls() {
  Scene scene;
  Mesh wall;
  wall.positions = {{-1, -1, 0}, {0, -1, 0}, {0, 1, 0}, {-1, 1, 0}};
  wall.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  const std::uint32_t far = AddLambert(scene, "far", {0.8f, 0.4f, 0.2f});
  AddMirror(scene, 1);
  const std::uint32_t near = AddLambert(scene, "near", {0.1f, 0.2f, 0.3f});
  Mesh lower = wall;
  for (glm::vec3& p : lower.positions) p = {p.x / 2, p.y < 0 ? -0.5f : 0.0f, 2};
  lower.material = near;
  // These normals lean to the right.
  lower.normals.assign(4, glm::normalize(glm::vec3(1, 0, 1)));
  wall.material = far;
  scene.meshes = {wall, lower};
  scene.camera = LookAtCamera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 2 * 14.0362435f, false);
  SetConstantLight(scene, 0.5f);
  return scene;
}

// Seen from behind, a wall has the numbers that it has from the front.
TEST(Aovs, IdsAreThoseOfBothSides) {
  Scene scene = TwoWalls();
  scene.camera = LookAtCamera({0, 0, -4}, {0, 0, 0}, {0, 1, 0}, 2 * 14.0362435f, false);
  const Layers layers = Resolve(MakeJob(scene, SmallRequest(20, 20, 4), "object-id,material-id"));
  std::set<float> objects, materials;
  for (const float id : layers.at("object-id.V")) objects.insert(id);
  for (const float id : layers.at("material-id.V")) materials.insert(id);
  EXPECT_EQ(objects, (std::set<float>{0, 1}));
  EXPECT_EQ(materials, (std::set<float>{0, 1}));
}

// A camera whose axes are longer than a unit, as files may have them, sees the same depths.
TEST(Aovs, DepthsAreThoseOfTheWorld) {
  for (const CameraKind kind : {CameraKind::kPerspective, CameraKind::kOrthographic}) {
    for (const float scale : {1.0f, 2.5f}) {
      Scene scene = TwoWalls();
      scene.camera->kind = kind;
      for (int axis = 0; axis < 3; ++axis) scene.camera->world_from_camera[axis] *= scale;
      JobRequest request = SmallRequest(20, 20, 4);
      request.filter = PixelFilter::kBox;
      const std::vector<float> depth = Resolve(MakeJob(scene, request, "depth")).at("depth.Z");
      EXPECT_NEAR(depth[9 * 20 + 9], 4, 1e-4) << scale;
      EXPECT_NEAR(depth[10 * 20 + 9], 2, 1e-4) << scale;
    }
  }
}

// From a place beside the middle of the walls.
TEST(Aovs, DistancesAndNormalsAreThoseOfTheCamera) {
  Scene scene = TwoWalls();
  JobRequest request = SmallRequest(20, 20, 16);
  request.filter = PixelFilter::kBox;
  for (const float scale : {1.0f, 2.5f}) {
    const float turn = 0.4f;
    const glm::vec3 eye(1, -0.5f, 4), view(-std::sin(turn), 0, -std::cos(turn));
    scene.camera = LookAtCamera(eye, eye + view, {0.3f, 1, 0}, 60, false);
    const glm::mat4 camera = scene.camera->world_from_camera;
    for (int axis = 0; axis < 3; ++axis) scene.camera->world_from_camera[axis] *= scale;
    const Layers layers =
        Resolve(MakeJob(scene, request, "distance,position,camera-normal,shading-normal,coverage"));
    int seen = 0;
    for (std::size_t i = 0; i < 400; ++i) {
      if (layers.at("coverage.V")[i] < 1) {
        if (layers.at("coverage.V")[i] == 0) {
          EXPECT_EQ(layers.at("distance.Z")[i], 1e10f);
        }
        continue;
      }
      ++seen;
      const auto at = [&](const std::string& name) {
        return glm::vec3(layers.at(name + ".X")[i], layers.at(name + ".Y")[i],
                         layers.at(name + ".Z")[i]);
      };
      EXPECT_NEAR(layers.at("distance.Z")[i], glm::length(at("position") - eye), 2e-3f);
      const glm::vec3 normal = at("shading-normal");
      const glm::vec3 expected(glm::dot(normal, glm::vec3(camera[0])),
                               glm::dot(normal, glm::vec3(camera[1])),
                               -glm::dot(normal, glm::vec3(camera[2])));
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(at("camera-normal")[axis], expected[axis], 1e-5f);
      EXPECT_GT(at("camera-normal").z, 0) << "surfaces face the camera";
    }
    EXPECT_GT(seen, 20);
  }
}

// Positions are on the surface itself, whichever way it faces; the walls are turned to face x.
TEST(Aovs, PositionsAreOnTheSurface) {
  Scene scene = TwoWalls();
  for (Mesh& mesh : scene.meshes) {
    for (glm::vec3& p : mesh.positions) p = {p.z, p.x, p.y};
    for (glm::vec3& n : mesh.normals) n = {n.z, n.x, n.y};
  }
  scene.camera = LookAtCamera({4, 0, 0}, {0, 0, 0}, {0, 0, 1}, 2 * 14.0362435f, false);
  JobRequest request = SmallRequest(20, 20, 4);
  request.filter = PixelFilter::kBox;
  const std::vector<float> x = Resolve(MakeJob(scene, request, "position")).at("position.X");
  EXPECT_NEAR(x[9 * 20 + 9], 0, 1e-5);
  EXPECT_NEAR(x[10 * 20 + 9], 2, 1e-5);
}

TEST(Aovs, LayersShowWhatTheCameraSees) {
  JobRequest request = SmallRequest(20, 20, 16);
  request.filter = PixelFilter::kBox;
  const Layers layers = Resolve(MakeJob(TwoWalls(), request, "all"));
  const auto at = [&](const char* name, int x, int y) { return layers.at(name)[y * 20 + x]; };
  // Rows 0 to 9 of the left half see the wall at z = 0, the others the one at z = 2.
  for (const int y : {0, 3, 9, 10, 15, 19}) {
    for (const int x : {0, 4, 9}) {
      const bool near = y >= 10;
      SCOPED_TRACE(testing::Message() << x << ", " << y);
      const float albedo[2][3] = {{0.8f, 0.4f, 0.2f}, {0.1f, 0.2f, 0.3f}};
      EXPECT_FLOAT_EQ(at("albedo.R", x, y), albedo[near][0]);
      EXPECT_FLOAT_EQ(at("albedo.G", x, y), albedo[near][1]);
      EXPECT_FLOAT_EQ(at("albedo.B", x, y), albedo[near][2]);
      EXPECT_NEAR(at("normal.X", x, y), 0, 1e-6);
      EXPECT_NEAR(at("normal.Y", x, y), 0, 1e-6);
      EXPECT_NEAR(at("normal.Z", x, y), 1, 1e-6);
      EXPECT_NEAR(at("shading-normal.X", x, y), near ? std::sqrt(0.5) : 0, 1e-4);
      EXPECT_NEAR(at("shading-normal.Z", x, y), near ? std::sqrt(0.5) : 1, 1e-4);
      EXPECT_NEAR(at("depth.Z", x, y), near ? 2 : 4, 1e-4);
      const double pixel = near ? 0.05 : 0.1;
      // Sixteen points of a (0, 2)-sequence have a mean within a 32nd of the pixel's centre.
      EXPECT_NEAR(at("position.X", x, y), (x - 9.5) * pixel, 0.05 * pixel);
      EXPECT_NEAR(at("position.Y", x, y), (9.5 - y) * pixel, 0.05 * pixel);
      EXPECT_NEAR(at("position.Z", x, y), near ? 2 : 0, 1e-4);
      // The value belongs to the sample nearest to the centre of a pixel. One of sixteen points of
      // the sequence lies in each of the four squares about it, a quarter of a pixel wide.
      const double v = near ? (19.5 - y) / 10 : (19.5 - y) / 20;
      EXPECT_NEAR(at("uv.U", x, y), (x + 0.5) / 10, 0.025);
      EXPECT_NEAR(at("uv.V", x, y), v, near ? 0.025 : 0.0125);
      EXPECT_EQ(at("uv.A", x, y), 1);
      EXPECT_EQ(at("object-id.V", x, y), near ? 2 : 1);
      EXPECT_EQ(at("material-id.V", x, y), near ? 3 : 1);
      EXPECT_EQ(at("coverage.V", x, y), 1);
      EXPECT_EQ(at("samples.V", x, y), 16);
    }
    for (const int x : {10, 19}) {
      for (const char* const name : {"albedo.R", "normal.Z", "shading-normal.Z", "position.Z",
                                     "uv.A", "object-id.V", "material-id.V", "coverage.V"}) {
        EXPECT_EQ(at(name, x, y), 0) << name;
      }
      EXPECT_EQ(at("depth.Z", x, y), 1e10f);
      EXPECT_EQ(at("samples.V", x, y), 16);
      EXPECT_EQ(at("direct.R", x, y), 0.5f);
      EXPECT_EQ(at("indirect.R", x, y), 0);
      EXPECT_EQ(at("variance.R", x, y), 0);
    }
  }
}

// At the edge of a wall, coverage is a fraction, means are over the hits, and ids are one or the
// other.
// From the middle of a ball everything is equally far, along the ray; a film that is a plane has
// depths along its axis.
TEST(Aovs, DepthIsAlongTheRayWhereTheFilmIsNoPlane) {
  Scene scene;
  Mesh ball = Sphere(2, 32);
  FlipOrientation(ball);
  Place(scene, ball, AddLambert(scene, "ball", glm::vec3(0.5f)), glm::vec3(0));
  SetConstantLight(scene, 1);
  scene.camera = LookAtCamera({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 90, false);
  for (const CameraKind kind : {CameraKind::kPerspective, CameraKind::kLatLong,
                                CameraKind::kEqualArea, CameraKind::kFisheye}) {
    SCOPED_TRACE(int(kind));
    JobRequest request = SmallRequest(16, 16, 16);
    request.camera.kind = kind;
    if (kind == CameraKind::kLatLong) request.height = 8;
    request.filter = PixelFilter::kBox;
    const std::vector<float> depths = Resolve(MakeJob(scene, request, "depth")).at("depth.Z");
    for (std::size_t i = 0; i < depths.size(); ++i) {
      if (kind == CameraKind::kFisheye && depths[i] > 1e9f) continue;  // beyond its circle
      double expected = 2;
      if (kind == CameraKind::kPerspective) {
        const glm::dvec2 on_plane((double(i % 16) + 0.5) / 8 - 1, (double(i / 16) + 0.5) / 8 - 1);
        expected /= std::sqrt(1 + glm::dot(on_plane, on_plane));
      }
      ASSERT_NEAR(depths[i], expected, 0.01) << i;
    }
    EXPECT_LT(std::count_if(depths.begin(), depths.end(), [](float depth) { return depth > 1e9f; }),
              std::ptrdiff_t(depths.size() / 3));
  }
}

TEST(Aovs, MeansAreOverTheSamplesThatHit) {
  JobRequest request = SmallRequest(21, 21, 64);  // the middle column sees the edge
  request.filter = PixelFilter::kBox;
  const Layers layers = Resolve(MakeJob(TwoWalls(), request, "albedo,coverage,object-id,depth"));
  for (const int y : {1, 4, 8}) {
    const int i = y * 21 + 10;
    EXPECT_NEAR(layers.at("coverage.V")[i], 0.5, 0.05);
    EXPECT_FLOAT_EQ(layers.at("albedo.R")[i], 0.8f);
    EXPECT_NEAR(layers.at("depth.Z")[i], 4, 1e-4);
  }
  for (const float id : layers.at("object-id.V")) EXPECT_TRUE(id == 0 || id == 1 || id == 2) << id;
}

// A single sample has the coordinates of the place that it has seen.
TEST(Aovs, CoordinatesAreThoseOfThePlace) {
  JobRequest request = SmallRequest(20, 20, 1);
  request.filter = PixelFilter::kBox;
  const Layers layers = Resolve(MakeJob(TwoWalls(), request, "uv,position"));
  double most = 0;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 10; ++x) {
      const std::size_t i = std::size_t(y * 20 + x);
      const bool near = y >= 10;
      const double width = near ? 0.5 : 1, height = near ? 0.5 : 2, bottom = near ? -0.5 : -1;
      const double px = layers.at("position.X")[i], py = layers.at("position.Y")[i];
      EXPECT_NEAR(layers.at("uv.U")[i], px / width + 1, 1e-5);
      EXPECT_NEAR(layers.at("uv.V")[i], (py - bottom) / height, 1e-5);
      const double pixel = near ? 0.05 : 0.1;
      most = std::max(most, std::abs(px - (x - 9.5) * pixel) / pixel);
    }
  }
  EXPECT_GT(most, 0.3) << "samples are not all in the middle";
}

// A triangle for each of 16 x 16 parts of a pixel shows which part a sample has seen, and all
// samples of a pixel one by one show which of them is nearest.
TEST(Aovs, IdsAreOfTheSampleNearestToTheCentre) {
  constexpr int kParts = 16, kPixels = 4, kSide = kParts * kPixels;
  constexpr std::uint32_t kSamples = 8;
  Scene scene;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const float left = float(x) / (kSide / 2) - 1, right = float(x + 1) / (kSide / 2) - 1;
      const float top = 1 - float(y) / (kSide / 2), bottom = 1 - float(y + 1) / (kSide / 2);
      Mesh part;
      part.positions = {{left, bottom, 0}, {right, bottom, 0}, {right, top, 0}, {left, top, 0}};
      part.triangles = {{0, 1, 2}, {0, 2, 3}};
      scene.meshes.push_back(std::move(part));
    }
  }
  AddLambert(scene, "wall", glm::vec3(0.5f));
  SetConstantLight(scene, 1);
  scene.camera = LookAtCamera({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 90, false);
  JobRequest request = SmallRequest(kPixels, kPixels, int(kSamples));
  request.filter = PixelFilter::kBox;
  const RenderJob job = MakeJob(scene, request, "object-id,material-id");
  // Returns the parts that samples [first, end) have seen, by pixel.
  const auto parts = [&](std::uint32_t first, std::uint32_t end) {
    FrameView frame = job.frame();
    frame.options.first_sample = first, frame.options.samples_per_pixel = end - first;
    const Layers layers = ByName(Render(job, frame).ResolveAovs(end - first));
    std::vector<glm::ivec2> seen;
    for (std::size_t i = 0; i < std::size_t(kPixels * kPixels); ++i) {
      const int id = int(layers.at("object-id.V")[i]) - 1;
      EXPECT_EQ(layers.at("material-id.V")[i], 1);
      seen.emplace_back(id % kSide, id / kSide);
      EXPECT_EQ(seen.back().x / kParts, int(i % kPixels));
      EXPECT_EQ(seen.back().y / kParts, int(i / kPixels));
    }
    return seen;
  };
  const std::vector<glm::ivec2> chosen = parts(0, kSamples);
  std::vector<std::vector<glm::ivec2>> each;
  for (std::uint32_t sample = 0; sample < kSamples; ++sample) {
    each.push_back(parts(sample, sample + 1));
  }
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const glm::dvec2 centre = double(kParts) * (glm::dvec2(i % kPixels, i / kPixels) + 0.5);
    const auto distance = [&](const glm::ivec2& part) {
      return glm::distance(glm::dvec2(part) + 0.5, centre);
    };
    bool is_one = false;
    for (std::uint32_t sample = 0; sample < kSamples; ++sample) {
      const glm::ivec2 part = each[sample][i];
      is_one = is_one || part == chosen[i];
      // Where a sample lies in its part is unknown, up to the diagonal.
      EXPECT_LE(distance(chosen[i]), distance(part) + std::sqrt(2.0)) << i << ' ' << sample;
    }
    EXPECT_TRUE(is_one) << i;
  }
}

TEST(Aovs, ChangeNoBitOfThePicture) {
  for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect}) {
    JobRequest request = SmallRequest(37, 29, 5);
    request.integrator = integrator;
    const RenderJob plain(PaintedScene(), request);
    EXPECT_EQ(Sums(Render(MakeJob(PaintedScene(), request, "all"))), Sums(Render(plain)));
    EXPECT_TRUE(Render(plain).ResolveAovs(5).empty());
  }
}

TEST(Aovs, BitsDoNotDependOnTheCut) {
  for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect}) {
    JobRequest request = SmallRequest(37, 29, 6);
    request.integrator = integrator;
    request.options.light_samples = 2;
    const RenderJob job = MakeJob(PaintedScene(), request, "all");
    const Layers reference = Resolve(job);
    EXPECT_EQ(reference.size(), 43u);
    for (const int threads : {1, 3}) {
      for (const std::uint32_t wave : {1u, 17u, 300u, 2048u}) {
        FrameView frame = job.frame();
        frame.options.threads = threads;
        frame.options.wave = wave;
        EXPECT_EQ(ByName(Render(job, frame).ResolveAovs(6)), reference) << wave;
      }
    }
    ForEachTarget([&] { EXPECT_EQ(Resolve(job), reference); });
    // The samples are rendered in parts, out of order.
    Film merged = job.MakeFilm();
    for (const auto& [first, count] : {std::pair{4u, 2u}, std::pair{0u, 1u}, std::pair{1u, 3u}}) {
      FrameView frame = job.frame();
      frame.options.first_sample = first;
      frame.options.samples_per_pixel = count;
      merged.Merge(Render(job, frame));
    }
    EXPECT_EQ(ByName(merged.ResolveAovs(6)), reference);
  }
}

// Direct light is bit-identical to a render with one surface per path; indirect light is the rest.
TEST(Aovs, DirectIsThePictureOfOneSurface) {
  for (const auto& [name, mis] :
       {std::pair{"spheres", true}, {"spheres", false}, {"gallery", true}}) {
    for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect}) {
      JobRequest request = SmallRequest(40, 30, 4);
      request.max_depth = 6;
      request.integrator = integrator;
      request.options.mis = mis;
      const Scene scene = BuiltinScene(name);
      const RenderJob job = MakeJob(scene, request, "direct,indirect");
      const Film film = Render(job);
      const Layers layers = ByName(film.ResolveAovs(4));
      request.max_depth = 1;
      const Image direct = Render(RenderJob(scene, request)).Resolve(4), beauty = film.Resolve(4);
      double indirect = 0;
      for (std::size_t i = 0; i < direct.rgb.size(); ++i) {
        const char letter[] = {"RGB"[i % 3], 0};
        const float d = layers.at(std::string("direct.") + letter)[i / 3];
        const float rest = layers.at(std::string("indirect.") + letter)[i / 3];
        ASSERT_EQ(d, direct.rgb[i]) << name << " " << i;
        ASSERT_NEAR(d + rest, beauty.rgb[i], 2e-7 * beauty.rgb[i]);
        indirect += rest;
      }
      EXPECT_GT(indirect, 0);
      // In a render with one surface, all light is direct.
      const Layers shallow = Resolve(MakeJob(scene, request, "indirect"));
      for (const char* const channel : {"indirect.R", "indirect.G", "indirect.B"}) {
        EXPECT_EQ(shallow.at(channel), std::vector<float>(40 * 30, 0)) << channel;
      }
    }
  }
}

// A variance over runs, and the square of its standard error.
struct Spread {
  double variance = 0, square_error = 0;
};
Spread SpreadOf(const std::vector<double>& runs) {
  const double n = double(runs.size());
  double mean = 0, m2 = 0, m4 = 0;
  for (const double x : runs) mean += x / n;
  for (const double x : runs) m2 += std::pow(x - mean, 2) / n, m4 += std::pow(x - mean, 4) / n;
  return {m2 * n / (n - 1), (m4 - m2 * m2) / n};
}

// Compares with independent renders of one sample each: the layer estimates their variance, except
// that the points of a sequence have a mean that varies less than that of independent ones: E[s^2]
// = n / (n - 1) * (variance of a sample - variance of the mean of n).
TEST(Aovs, VarianceIsThatOfIndependentSamples) {
  constexpr std::size_t kRuns = 1500, kPixels = 8 * 6;
  constexpr std::uint32_t kSamples = 8;
  JobRequest request = SmallRequest(8, 6, 1);
  request.options.threads = 1;
  Scene scene = PaintedScene();
  SetLight(scene, SkyWithSun(64, 32, 1, 0.4));  // without rare bright samples
  const RenderJob single = MakeJob(scene, request, "variance");
  request.samples_per_pixel = kSamples;
  const RenderJob job = MakeJob(scene, request, "variance");
  using Runs = std::vector<std::vector<double>>;
  Runs of_sample(kPixels), of_mean(kPixels), of_layer(kPixels);
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    FrameView frame = single.frame();
    frame.options.seed = 1000 + run;
    const Film one = Render(single, frame);
    EXPECT_EQ(ByName(one.ResolveAovs(1)).at("variance.G"), std::vector<float>(kPixels, 0));
    frame = job.frame();
    frame.options.seed = 5000 + run;
    const Film film = Render(job, frame);
    const Layers layers = ByName(film.ResolveAovs(kSamples));
    const Image a = one.Resolve(1), b = film.Resolve(kSamples);
    for (std::size_t i = 0; i < kPixels; ++i) {
      of_sample[i].push_back(a.rgb[i * 3 + 1]);
      of_mean[i].push_back(b.rgb[i * 3 + 1]);
      of_layer[i].push_back(layers.at("variance.G")[i]);
    }
  }
  double told = 0, expected = 0, square_error = 0;
  const double factor = kSamples / (kSamples - 1.0);
  for (std::size_t i = 0; i < kPixels; ++i) {
    const Spread sample = SpreadOf(of_sample[i]), mean = SpreadOf(of_mean[i]);
    for (const double x : of_layer[i]) told += x / kRuns;
    expected += factor * (sample.variance - mean.variance);
    square_error += SpreadOf(of_layer[i]).variance / kRuns +
                    factor * factor * (sample.square_error + mean.square_error);
  }
  // Four standard errors must be small for the test to be meaningful.
  EXPECT_NEAR(told, expected, 4 * std::sqrt(square_error));
  EXPECT_LT(4 * std::sqrt(square_error), 0.1 * expected);
}

TEST(Aovs, NamesAreParsedAndListed) {
  EXPECT_EQ(ToString(ParseAovs("depth,albedo").value()), "albedo,depth");
  EXPECT_EQ(ParseAovs(ToString(AllAovs())), AllAovs());
  EXPECT_EQ(ParseAovs("all"), AllAovs());
  for (const char* const bad :
       {"", ",", "albedo,", "albedo,,depth", "Albedo", "albedo, depth", "al"}) {
    EXPECT_FALSE(ParseAovs(bad)) << bad;
  }
}

TEST(Aovs, FirstSurfacesNeedADepthOfOne) {
  JobRequest request = SmallRequest(4, 3, 1);
  request.max_depth = 0;
  EXPECT_THROW(MakeJob(TwoWalls(), request, "albedo"), InputError);
  EXPECT_THROW(MakeJob(TwoWalls(), request, "coverage"), InputError);
  const Layers layers = Resolve(MakeJob(TwoWalls(), request, "direct,variance,samples"));
  EXPECT_EQ(layers.at("direct.R")[3], 0.5f);
}

}  // namespace
}  // namespace skywave
