// Renders the edges of a bright rectangle and compares pixels with the convolution of the rectangle
// and the filter.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "scene/shapes/mesh.h"
#include "tests/support/render_scenes.h"
#include "wavefront/option_names.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kWidth = 16, kHeight = 12;
// The rectangle covers the film from its top left corner to here, and beyond [pixels].
constexpr double kRight = 7.3, kBottom = 5.8;

// Returns the filters as their authors give them, not normalised, at x pixels.
double Weight(PixelFilter filter, double radius, double x) {
  const double t = std::fabs(x);
  if (t > radius) return 0;
  if (filter == PixelFilter::kBox) return 1;
  if (filter == PixelFilter::kMitchell) {
    constexpr double b = 1.0 / 3, c = 1.0 / 3;
    const double u = 2 * t / radius, u2 = u * u, u3 = u2 * u;
    return u < 1 ? (12 - 9 * b - 6 * c) * u3 + (-18 + 12 * b + 6 * c) * u2 + (6 - 2 * b)
                 : (-b - 6 * c) * u3 + (6 * b + 30 * c) * u2 + (-12 * b - 48 * c) * u + 8 * b +
                       24 * c;
  }
  const auto sinc = [](double v) { return v < 1e-9 ? 1.0 : std::sin(kPi * v) / (kPi * v); };
  return sinc(t) * sinc(t / 3);
}

// Returns the share of the filter at `centre` that lies below `edge`.
double Below(PixelFilter filter, double radius, double centre, double edge) {
  constexpr int kSteps = 20000;
  double below = 0, all = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = radius * (2 * (i + 0.5) / kSteps - 1), weight = Weight(filter, radius, x);
    all += weight;
    if (centre + x < edge) below += weight;
  }
  return below / all;
}

// The camera looks along -z on a film of one pixel a unit.
Scene BrightRectangle() {
  Scene scene;
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
  scene.materials[lamp].emission = {1, 2, 0.5f};
  scene.materials[lamp].emits_on_both_sides = true;
  const float right = float(kRight - kWidth / 2.0), bottom = float(kHeight / 2.0 - kBottom);
  Mesh mesh;
  mesh.positions = {{-50, bottom, 0}, {right, bottom, 0}, {right, 50, 0}, {-50, 50, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.material = lamp;
  scene.meshes.push_back(mesh);
  scene.camera = LookAtCamera({0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 45, false);
  scene.camera->kind = CameraKind::kOrthographic;
  scene.camera->window =
      ScreenWindow{-kWidth / 2.0f, kWidth / 2.0f, -kHeight / 2.0f, kHeight / 2.0f};
  SetConstantLight(scene, 0);
  return scene;
}

JobRequest Request(PixelFilter filter, std::uint32_t samples) {
  JobRequest request = SmallRequest(kWidth, kHeight, samples);
  request.filter = filter;
  request.integrator = Integrator::kDirect;
  request.max_depth = 0;
  return request;
}

TEST(PixelFilters, PicturesAreConvolutions) {
  for (const auto& [filter, radius] : {std::pair{PixelFilter::kBox, 0.5},
                                       {PixelFilter::kMitchell, 2.0},
                                       {PixelFilter::kMitchell, 3.5},
                                       {PixelFilter::kSinc, 4.0}}) {
    SCOPED_TRACE(std::string(ToString(filter)) + " " + std::to_string(radius));
    JobRequest request = Request(filter, 16384);
    request.options.filter_radius = float(radius);
    const RenderJob job(BrightRectangle(), request);
    Film film = job.MakeFilm();
    RenderFrame(job.frame(), film);
    const Image picture = film.Resolve(job.options().samples_per_pixel);
    double least = 1, most = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double expected =
            Below(filter, radius, x + 0.5, kRight) * Below(filter, radius, y + 0.5, kBottom);
        for (int c = 0; c < 3; ++c) {
          const double radiance = c == 0 ? 1 : c == 1 ? 2 : 0.5;
          ASSERT_NEAR(picture.Pixel(x, y)[c] / radiance, expected, 0.006) << x << " " << y;
        }
        least = std::min(least, expected), most = std::max(most, expected);
      }
    }
    // The lobes that are negative darken and brighten both sides of an edge.
    EXPECT_EQ(least < -0.005 && most > 1.005, filter != PixelFilter::kBox);
  }
}

// Splats and parts of the light have no signs.
TEST(PixelFilters, SignsAreRefusedWhereTheyAreNotKept) {
  JobRequest request = Request(PixelFilter::kMitchell, 4);
  request.integrator = Integrator::kBdpt;
  EXPECT_THROW(RenderJob(BrightRectangle(), request), InputError);
  request.filter.reset();
  Scene scene = BrightRectangle();
  scene.settings.filter = PixelFilter::kSinc;
  scene.settings.filter_radius = 4;
  const RenderJob job(scene, request);
  EXPECT_EQ(job.options().filter, PixelFilter::kBlackmanHarris);
  EXPECT_EQ(job.options().filter_radius, 1.5f);
  EXPECT_NE(job.notes().front().find("sinc"), std::string::npos);
  request.integrator = Integrator::kPath;
  EXPECT_EQ(RenderJob(scene, request).options().filter, PixelFilter::kSinc);
}

}  // namespace
}  // namespace skywave
