// Tests caustics of lights without extent: the light that a glass ball focuses on a floor, seen
// directly, where light paths find it, and in a mirror, where only photons and merged vertices do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kIor = 1.5, kHeight = 1.8;  // index of the ball of radius 1, and height of its
                                             // centre
constexpr double kWindow = 1.3;              // half of the visible floor
constexpr float kAlbedo = 0.02f;             // dark, so that hardly any light returns to the ball
constexpr double kElevation = 20 * kPi / 180;
constexpr float kMirror = 2.2f;  // the plane z = -kMirror, up to a height of kMirrorTop
constexpr float kMirrorTop = 1.3f;
constexpr int kRuns = 12;
const double kLevel = SidakLevel(8);

enum class Source { kSun, kSpot, kPoint };
std::string NameOf(Source source) {
  return source == Source::kSun ? "Sun" : source == Source::kSpot ? "Spot" : "Point";
}

PunctualLight LightOf(Source source) {
  const glm::vec3 above(0, 4.6f, 0);
  switch (source) {
    case Source::kSun:
      return {.kind = LocalLightKind::kDistant, .emission = {3, 2, 1}, .direction = {0, 1, 0}};
    case Source::kSpot:
      return {.kind = LocalLightKind::kSpot,
              .emission = {30, 20, 10},
              .position = above,
              .direction = {0, -1, 0},
              .cos_full = 0.95f,
              .cos_dark = 0.9f};
    case Source::kPoint:
      return {.emission = {30, 20, 10}, .position = above};
  }
  return {};
}

// Apart from the mirror, the scene is symmetric in z, and so is the light on the floor. In the
// mirror, a camera sees the floor as another camera would from the opposite side; the mirror is too
// low to reflect light of the source, or much light from the ball, onto the visible floor.
Scene CausticScene(Source source, bool in_mirror) {
  Scene scene;
  Place(scene, Facetted(Quad(2)), AddLambert(scene, "floor", glm::vec3(kAlbedo)), glm::vec3(0));
  Place(scene, Sphere(1, 40), AddGlass(scene, float(kIor)), {0, kHeight, 0});
  scene.lights = {LightOf(source)};
  SetConstantLight(scene, 0);
  const auto sine = float(std::sin(kElevation)), cosine = float(std::cos(kElevation));
  glm::vec3 eye(0, 3 * sine, 3 * cosine), target(0);
  if (in_mirror) {
    Mesh mirror = Facetted(Quad(1.6f));
    for (glm::vec3& p : mirror.positions) {
      p = {p.x, 0.5f * kMirrorTop * (1 + p.z / 1.6f), -kMirror};
    }
    Place(scene, mirror, AddMirror(scene, 1), glm::vec3(0));
    // The camera is in front of the mirror, and the ball is behind the camera.
    eye = {0, kMirror * sine / cosine + 0.8f * sine, -kMirror + 0.8f * cosine};
    target = {0, kMirror * sine / cosine, -kMirror};
  }
  scene.camera = LookAtCamera(eye, target, {0, 1, 0}, 45, false);
  scene.camera->kind = CameraKind::kOrthographic;
  const float half = float(kWindow);
  scene.camera->window = {.left = -half, .right = half, .bottom = -half * sine, .top = half * sine};
  return scene;
}

JobRequest Request(Integrator integrator, std::uint32_t samples, bool in_mirror = false) {
  JobRequest request = SmallRequest(24, 9, samples);
  request.integrator = integrator;
  request.max_depth = in_mirror ? 4 : 3;  // in and out of the ball, the floor, the mirror
  request.filter = PixelFilter::kBox;
  return request;
}

PictureEstimate Blocks(const PictureEstimate& picture) { return MeanOfBlocks(picture, 3); }

// The reference consists of unbiased light paths.
PictureEstimate Reference(const Scene& scene) {
  return Blocks(EstimateFromEngine(RenderJob(scene, Request(Integrator::kLight, 128)), kRuns, 100));
}

// Returns the difference of a picture of `passes` passes from `expected`. The first radius is large
// enough to blur.
double DifferenceOf(const Scene& scene, bool in_mirror, Integrator integrator, std::uint32_t passes,
                    const PictureEstimate& expected) {
  JobRequest request = Request(integrator, 4 * passes, in_mirror);
  request.options.of<PhotonOptions>() = {.indirect = integrator == Integrator::kVcm ? 100000u : 0,
                                         .caustic = 1000,
                                         .distance = 0.3f,
                                         .gather = 0,
                                         .passes = passes};
  return RelativeDifference(Blocks(EstimateFromEngine(RenderJob(scene, request), 1, 7)), expected);
}

double MeanOf(const PictureEstimate& picture, std::size_t channel) {
  return MeanOfBlocks(picture, std::max(picture.width, picture.height)).mean[channel];
}

// Returns the reflectance of glass for unpolarised light (Fresnel).
double Reflectance(double cos_i) {
  const double cos_t = std::sqrt(1 - (1 - cos_i * cos_i) / (kIor * kIor));
  const double s = (cos_i - kIor * cos_t) / (cos_i + kIor * cos_t);
  const double p = (kIor * cos_i - cos_t) / (kIor * cos_i + cos_t);
  return 0.5 * (s * s + p * p);
}

// Returns the fraction of a circle of this radius about the middle that lies in the window.
double ShareInWindow(double radius) {
  radius = std::fabs(radius);
  if (radius <= kWindow) return 1;
  return radius < kWindow * std::numbers::sqrt2 ? 1 - 4 / kPi * std::acos(kWindow / radius) : 0;
}

// Returns the mean radiance of the window under a sun of irradiance 1: the light that misses the
// ball and, circle by circle, the light that passes through it or reflects from its upper side, in
// the plane of the ray and the axis.
double ExactMean() {
  constexpr int kSteps = 20000;
  double power = 0;  // in the window [times the irradiance]
  for (int i = 0; i < kSteps; ++i) {
    const double b = (i + 0.5) / kSteps, circle = 2 * kPi * b / kSteps;
    const double in = std::asin(b), out = std::asin(b / kIor);
    const double reflected = Reflectance(std::cos(in));
    // `leaves` is the angle of the exit point from the top, `turn` the angle of the exit ray from
    // straight down.
    const double leaves = in + kPi - 2 * out, turn = 2 * (in - out);
    if (std::cos(turn) > 0) {
      const double distance = (kHeight + std::cos(leaves)) / std::cos(turn);
      const double share = ShareInWindow(std::sin(leaves) - distance * std::sin(turn));
      power += circle * (1 - reflected) * (1 - reflected) * share;
    }
    if (std::cos(2 * in) < 0) {
      const double distance = (kHeight + std::cos(in)) / -std::cos(2 * in);
      power += circle * reflected * ShareInWindow(std::sin(in) + distance * std::sin(2 * in));
    }
  }
  const double area = 4 * kWindow * kWindow;
  return kAlbedo / kPi * (area - kPi + power) / area;
}

TEST(Caustics, TheCausticOfASunMatchesRayOptics) {
  const PictureEstimate picture = Reference(CausticScene(Source::kSun, false));
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(MeanOf(picture, c) / (3 - double(c)) / ExactMean(), 1, 0.004) << "channel " << c;
  }
}

class CausticsOf : public testing::TestWithParam<Source> {};

TEST_P(CausticsOf, AllIntegratorsAgreeDirectlyAndInAMirror) {
  const PictureEstimate expected = Reference(CausticScene(GetParam(), false));
  const PictureEstimate bdpt = Blocks(EstimateFromEngine(
      RenderJob(CausticScene(GetParam(), false), Request(Integrator::kBdpt, 32)), kRuns, 500));
  EXPECT_TRUE(SamePicture(bdpt, expected, kLevel));
  for (const bool in_mirror : {false, true}) {
    const Scene scene = CausticScene(GetParam(), in_mirror);
    for (const Integrator integrator : {Integrator::kPhoton, Integrator::kVcm}) {
      SCOPED_TRACE(std::string(ToString(integrator)) + (in_mirror ? " in the mirror" : ""));
      const double first = DifferenceOf(scene, in_mirror, integrator, 2, expected);
      const double last = DifferenceOf(scene, in_mirror, integrator, 32, expected);
      std::printf("%.4f after 2 passes, %.4f after 32\n", first, last);
      EXPECT_LT(last, 0.6 * first);
      EXPECT_LT(last, 0.04);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Each, CausticsOf,
                         testing::Values(Source::kSun, Source::kSpot, Source::kPoint),
                         [](const auto& test) { return NameOf(test.param); });

}  // namespace
}  // namespace skywave
