// Compares the lens of realistic cameras with the lensmaker's equation, with double arithmetic, and
// with the irradiance behind a hole.
#include "scene/lens_system.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <string>

#include "base/error.h"
#include "base/files.h"
#include "job/choose_camera.h"
#include "job/job.h"
#include "kernels/camera.h"
#include "scene/pbrt/reader.h"
#include "tests/support/random_rows.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

// A biconvex lens, a stop and a meniscus, of metres; 24 mm of film.
LensDesign Doublet() {
  LensDesign design;
  design.interfaces = {{0.060, 0.006, 1.6, 0.012},
                       {-0.080, 0.004, 1, 0.012},
                       {0, 0.003, 0, 0.004},
                       {-0.030, 0.002, 1.5, 0.008},
                       {-0.045, 0.040, 1, 0.008}};
  design.film_diagonal = 0.024;
  return design;
}

// A hole of radius 2 mm, 10 mm from the film.
LensDesign Hole(LensWeight weight) {
  LensDesign design;
  design.interfaces = {{0, 0.010, 0, 0.002}};
  design.film_diagonal = 0.024;
  design.weight = weight;
  return design;
}

Camera CameraWith(const LensDesign& design) {
  Camera camera = LookAtCamera({1, 2, 3}, {-4, 1.5f, 8}, {0.1f, 1, 0.2f}, 37, false);
  camera.kind = CameraKind::kRealistic;
  camera.realistic = std::make_shared<const LensSystem>(design);
  return camera;
}

// Rays through the middle of pixels of a film of 16 x 12.
struct FilmRays {
  static constexpr int kWidth = 16, kHeight = 12;
  FilmRays(const Camera& camera, std::uint32_t n, std::uint32_t seed)
      : paths(n), lens(RandomUniforms(n, seed)), rays(n) {
    const std::vector<float> middle(kFilterCells + 1, 0.0f);
    const CameraView view = MakeCameraView(camera, kWidth, kHeight, middle.data());
    for (std::uint32_t i = 0; i < n; ++i) paths->pixel[i] = i % (kWidth * kHeight);
    GenerateCameraRays(view, paths, lens, lens, n, rays);
  }
  soa::Table<PathColumns> paths;
  soa::Table<UniformColumns> lens;
  soa::Table<RayColumns> rays;
};

TEST(LensSystem, FocalLengthIsThatOfTheLensmaker) {
  for (const auto& [front, rear] : {std::pair(0.06, -0.08), {0.05, 0.4}, {-0.2, -0.04}}) {
    constexpr double kThickness = 0.006, kIor = 1.6;
    LensDesign design;
    design.interfaces = {{front, kThickness, kIor, 0.01}, {rear, 0.03, 1, 0.01}};
    design.film_diagonal = 1e-3;
    const double power =
        (kIor - 1) * (1 / front - 1 / rear + (kIor - 1) * kThickness / (kIor * front * rear));
    EXPECT_NEAR(FocalLength(design) * power, 1, 1e-6) << front << " " << rear;
  }
}

// Rays from the middle of the film meet in the point in focus, and those of another place in one
// that is as far away across as magnified.
TEST(LensSystem, FocusesWhatIsAtItsDistance) {
  for (const double distance : {0.6, 2.0, 50.0}) {
    LensDesign design = Doublet();
    for (LensInterface& at : design.interfaces) {
      if (at.radius == 0) at.aperture = 1e-4;  // paraxial
    }
    ASSERT_TRUE(FocusLens(design, distance));
    double rear = design.interfaces.back().thickness;
    int passed = 0;
    for (const double at : {-8e-5, -3e-5, 2e-5, 6e-5}) {
      const double length = std::hypot(at, rear);
      const auto ray = FollowFromFilm(design, {{0, 0, 0}, {at / length, 0, rear / length}});
      if (!ray) continue;
      ++passed;
      const double z = ray->origin[2] - ray->origin[0] * ray->dir[2] / ray->dir[0];
      EXPECT_NEAR(z / distance, 1, 2e-3) << at;
    }
    EXPECT_GE(passed, 2);
  }
  LensDesign near = Doublet();
  EXPECT_FALSE(FocusLens(near, 0.05)) << "nearer than four focal lengths from its image";
  EXPECT_EQ(near.interfaces.back().thickness, 0.040);
}

TEST(LensSystem, KernelFollowsRaysAsDoubleArithmeticDoes) {
  LensDesign design = Doublet();
  ASSERT_TRUE(FocusLens(design, 2));
  const Camera camera = CameraWith(design);
  const LensView& lens = camera.realistic->view;
  const glm::dmat4 world(camera.world_from_camera);
  constexpr std::uint32_t kRays = 20 * 192;
  const double side = design.film_diagonal / 20;  // the hypotenuse of 16 and 12
  ForEachTarget([&] {
    const FilmRays r(camera, kRays, 5);
    std::uint32_t passed = 0, stopped = 0, different = 0;
    for (std::uint32_t i = 0; i < kRays; ++i) {
      const double x = (8 - (i % 16 + 0.5)) * side, y = (i / 16 % 12 + 0.5 - 6) * side;
      const double radius = std::hypot(x, y);
      const auto box = std::min(std::uint32_t(radius / lens.half_diagonal * kPupils), kPupils - 1);
      const double px = double(lens.pupil_x[box]) + double(r.lens->u[i]) * lens.pupil_width[box];
      const double py = double(lens.pupil_y[box]) + double(r.lens->v[i]) * lens.pupil_height[box];
      const glm::dvec3 film(x, y, 0),
          rear((x * px - y * py) / radius, (y * px + x * py) / radius, double(lens.vertex[0]));
      const glm::dvec3 dir = glm::normalize(rear - film);
      const auto exact = FollowFromFilm(design, {{x, y, 0}, {dir.x, dir.y, dir.z}});
      const float throughput = r.rays->throughput_r[i];
      if (exact.has_value() != (throughput > 0)) {
        ++different;  // at an edge
        continue;
      }
      ASSERT_EQ(r.rays->t_far[i] > 0, exact.has_value());
      if (!exact) {
        ++stopped;
        continue;
      }
      ++passed;
      ASSERT_NEAR(throughput / (std::pow(dir.z, 4) * lens.pupil_weight[box]), 1, 1e-5);
      const auto in_world = [&](const double(&v)[3], double w) {
        const glm::dvec4 p = world * glm::dvec4(v[0], v[1], v[2], w);
        return Vec{p.x, p.y, p.z};
      };
      ASSERT_LT(Angle(Get(i, r.rays->dir_x, r.rays->dir_y, r.rays->dir_z), in_world(exact->dir, 0)),
                1e-5);
      ASSERT_LT(
          Length(Get(i, r.rays->org_x, r.rays->org_y, r.rays->org_z) - in_world(exact->origin, 1)),
          2e-6);
    }
    EXPECT_GT(passed, kRays / 3);
    EXPECT_GT(stopped, kRays / 20);
    EXPECT_LT(different, kRays / 500);
  });
}

// Behind a hole under an even sky, irradiance is the integral of cos^4 / distance^2 over the hole.
TEST(LensSystem, ThroughputIsIrradiance) {
  const auto irradiance = [](double x, double y) {
    constexpr int kSteps = 400;
    constexpr double kRadius = 0.002, kDistance = 0.010;
    double sum = 0;
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const double px = (2 * (i % kSteps + 0.5) / kSteps - 1) * kRadius,
                   py = (2 * (i / kSteps + 0.5) / kSteps - 1) * kRadius;
      if (px * px + py * py > kRadius * kRadius) continue;
      const double d2 = (px - x) * (px - x) + (py - y) * (py - y) + kDistance * kDistance;
      sum += kDistance * kDistance / (d2 * d2);
    }
    return sum * std::pow(2 * kRadius / kSteps, 2);
  };
  // On the axis it is pi times the square of the sine.
  EXPECT_NEAR(irradiance(0, 0), kPi * 4 / 104, 1e-4);
  constexpr std::uint32_t kSamples = 2000, kPixels = 192;
  for (const LensWeight weight : {LensWeight::kIrradiance, LensWeight::kRelative}) {
    const Camera camera = CameraWith(Hole(weight));
    const FilmRays r(camera, kSamples * kPixels, 9);
    // The hole takes pi / 4 of the square around it, and the margin of the box a little.
    const LensView& lens = camera.realistic->view;
    const double box = double(lens.pupil_width[0]) * double(lens.pupil_height[0]);
    EXPECT_NEAR(box / 16e-6, 1, 0.04);
    const double unit = weight == LensWeight::kRelative ? box / 1e-4 : 1;
    for (const std::uint32_t pixel : {0u, 7u, 103u, 104u, 191u}) {
      double sum = 0, squares = 0;
      for (std::uint32_t i = pixel; i < kSamples * kPixels; i += kPixels) {
        const double value = double(r.rays->throughput_r[i]);
        sum += value, squares += value * value;
      }
      const double mean = sum / kSamples;
      const double error = std::sqrt((squares / kSamples - mean * mean) / kSamples);
      const double side = 0.024 / 20, x = (8 - (pixel % 16 + 0.5)) * side,
                   y = (pixel / 16 + 0.5 - 6) * side;
      EXPECT_NEAR(mean * unit, irradiance(x, y), 4 * error * unit) << pixel;
    }
  }
}

// Textures are blurred over what a pixel sees: its side by the focal length, on the axis.
TEST(LensSystem, PixelsAreAsWideAsTheFocalLengthSays) {
  LensDesign design = Doublet();
  const CameraView view = MakeCameraView(CameraWith(design), 160, 120, nullptr);
  EXPECT_NEAR(PixelSize(view, 7), 7 * 0.024 / 200 / FocalLength(design), 1e-6);
}

TEST(LensSystem, BoxesHoldThePupil) {
  LensDesign design = Doublet();
  ASSERT_TRUE(FocusLens(design, 2));
  const LensSystem lens(design);
  Random random(3);
  int outside = 0;
  for (int i = 0; i < 200000; ++i) {
    const double x = random.Float() * design.film_diagonal / 2;
    const glm::dvec3 rear((2 * random.Float() - 1) * 0.012, (2 * random.Float() - 1) * 0.012,
                          double(lens.view.vertex[0]));
    const glm::dvec3 dir = glm::normalize(rear - glm::dvec3(x, 0, 0));
    if (!FollowFromFilm(design, {{x, 0, 0}, {dir.x, dir.y, dir.z}})) continue;
    const auto box = std::size_t(x / (design.film_diagonal / 2) * kPupils);
    const double from_left = rear.x - double(lens.view.pupil_x[box]),
                 from_low = rear.y - double(lens.view.pupil_y[box]);
    outside += from_left < 0 || from_left > lens.view.pupil_width[box] || from_low < 0 ||
               from_low > lens.view.pupil_height[box];
  }
  EXPECT_EQ(outside, 0);
}

// The numbers of a file are millimetres, and each version of pbrt has weights of its own.
class RealisticCamera : public testing::Test {
 protected:
  void SetUp() override {
    WriteFileAtomically(folder_.Path("lens.dat"),
                        "# a singlet behind a stop\n0 2 0 8\n40 4 1.5 20 # front\n-40 30 1 20\n");
  }
  Scene Read(const std::string& camera, const std::string& rest = "WorldBegin Shape \"sphere\"") {
    return ParsePbrt(
        "Camera \"realistic\" " + camera + " Film \"rgb\" \"float diagonal\" 20 " + rest,
        folder_.Path("t.pbrt"));
  }
  TemporaryFolder folder_;
};

TEST_F(RealisticCamera, HasTheLensOfItsFile) {
  const std::string lens = "\"string lensfile\" \"lens.dat\" \"float focusdistance\" 2 ";
  const Scene v4 = Read(lens + "\"float aperturediameter\" 5");
  ASSERT_TRUE(v4.warnings.empty()) << v4.warnings[0];
  ASSERT_EQ(v4.camera->kind, CameraKind::kRealistic);
  const LensDesign& design = v4.camera->realistic->design;
  ASSERT_EQ(design.interfaces.size(), 3u);
  EXPECT_DOUBLE_EQ(design.interfaces[1].radius, 0.040);
  EXPECT_NEAR(design.interfaces[0].aperture, 0.0025, 1e-9) << "half of the smaller diameter";
  EXPECT_DOUBLE_EQ(design.interfaces[2].aperture, 0.010) << "only the stop is closed";
  EXPECT_NEAR(design.film_diagonal, 0.020, 1e-9);
  EXPECT_EQ(design.weight, LensWeight::kIrradiance);
  EXPECT_GT(design.interfaces[2].thickness, 0.030) << "moved to focus";
  const auto design_of = [](const Scene& scene) { return scene.camera->realistic->design; };
  const std::string v3 = "WorldBegin Shape \"sphere\" WorldEnd";
  EXPECT_EQ(design_of(Read(lens, v3)).weight, LensWeight::kRelative);
  const LensDesign timed =
      design_of(Read(lens + "\"bool simpleweighting\" \"false\" \"float shutterclose\" .25", v3));
  EXPECT_EQ(timed.weight, LensWeight::kIrradiance);
  EXPECT_EQ(timed.gain, 0.25);
}

TEST_F(RealisticCamera, IsPerspectiveWhereItsLensIsMissing) {
  for (const std::string camera :
       {"\"string lensfile\" \"none.dat\"", "",
        "\"string lensfile\" \"lens.dat\" \"float focusdistance\" .05"}) {
    const Scene scene = Read(camera);
    EXPECT_EQ(scene.camera->kind, CameraKind::kPerspective) << camera;
    ASSERT_EQ(scene.warnings.size(), 1u) << camera;
    EXPECT_NE(scene.warnings[0].find("rendered as perspective"), std::string::npos);
  }
  WriteFileAtomically(folder_.Path("bad.dat"), "40 4 1.5 20\n-40 30 x 20\n");
  EXPECT_NE(Read("\"string lensfile\" \"bad.dat\"").warnings.at(0).find("bad.dat:2"),
            std::string::npos);
  for (const char* const numbers : {"40 4 1.5", "40 4 1.5 200", "40 -4 1.5 20", "40 4 nan 20"}) {
    WriteFileAtomically(folder_.Path("bad.dat"), numbers);
    EXPECT_EQ(Read("\"string lensfile\" \"bad.dat\"").warnings.size(), 1u) << numbers;
  }
}

TEST_F(RealisticCamera, IsRefusedWhereItCannotBe) {
  Scene scene = Read("\"string lensfile\" \"lens.dat\" \"float focusdistance\" 2",
                     "WorldBegin LightSource \"infinite\" Translate 0 0 4 Shape \"sphere\"");
  JobRequest request = SmallRequest(16, 12, 1);
  // To ask for the camera of the scene changes nothing, though it looks upwards.
  scene.camera->world_from_camera = glm::rotate(glm::mat4(2), 0.7f, glm::vec3(1, 0, 0));
  scene.camera->world_from_camera[3] = glm::vec4(1, 2, 3, 1);
  CameraRequest same;
  same.kind = CameraKind::kRealistic;
  const Bounds bounds = {glm::vec3(-1), glm::vec3(1)};
  EXPECT_EQ(ChooseCamera(scene, bounds, same, 1).world_from_camera,
            ChooseCamera(scene, bounds, {}, 1).world_from_camera);
  EXPECT_NO_THROW(RenderJob(scene, request));
  request.camera.fov_degrees = 40;
  ExpectRefused(scene, request, "lens file");
  request.camera.kind = CameraKind::kPerspective;
  EXPECT_NO_THROW(RenderJob(scene, request));
  request = SmallRequest(16, 12, 1);
  request.integrator = Integrator::kBdpt;
  ExpectRefused(scene, request, "no connection goes through the lens");
  scene.camera = LookAtCamera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 40, true);
  request = SmallRequest(16, 12, 1);
  request.camera.kind = CameraKind::kRealistic;
  ExpectRefused(scene, request, "a scene with a lens file");
}

}  // namespace
}  // namespace skywave
