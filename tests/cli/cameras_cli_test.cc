// Holds every camera that the program offers to what it must see: a black triangle in front of a
// white map, whose silhouette is computed by rays of another form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <string>

#include "image/image.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

enum class Kind { kPerspective, kOrthographic, kLatLong, kEqualArea, kFisheye };

// Options of a camera, and what they say.
struct View {
  std::string options;
  Kind kind = Kind::kPerspective;
  glm::dvec3 eye = {0.3, 0.2, 2}, target = {0.3, 0.2, 0};
  double fov_degrees = 50;
  double lens_radius = 0, focal_distance = 2;
};

// Whether a ray passes the triangle, which lies in the plane z = 0 with its right angle at the
// origin.
bool Passes(const glm::dvec3& origin, const glm::dvec3& dir) {
  const double t = -origin.z / dir.z;
  const glm::dvec3 hit = origin + t * dir;
  return !(t > 0 && hit.x >= 0 && hit.y >= 0 && hit.x + hit.y <= 1);
}

// Returns how much light arrives at a point of a film of `size` [pixels].
double LightAt(const View& view, const glm::dvec2& at, const glm::dvec2& size) {
  const glm::dvec3 ahead = glm::normalize(view.target - view.eye);
  const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 1, 0)));
  const glm::dvec3 up = glm::cross(right, ahead);
  // The shorter side goes from -1 to 1.
  const double shorter = std::min(size.x, size.y);
  const double x = (at.x - size.x / 2) * 2 / shorter, y = (size.y / 2 - at.y) * 2 / shorter;
  const double slope = std::tan(view.fov_degrees * kPi / 360);
  const glm::dvec3 across = slope * (x * right + y * up);
  glm::dvec3 from = view.eye, dir = ahead + across;
  switch (view.kind) {
    case Kind::kPerspective:
      break;
    case Kind::kOrthographic: {
      // It shows as much of the middle of the scene as the perspective camera would.
      const glm::dvec3 middle(0.5, 0.5, 0);
      from += glm::dot(middle - view.eye, ahead) * across, dir = ahead;
      break;
    }
    case Kind::kLatLong: {
      const double theta = kPi * at.y / size.y, phi = 2 * kPi * (at.x / size.x - 0.5);
      dir = std::sin(theta) * (std::sin(phi) * right + std::cos(phi) * ahead);
      dir += std::cos(theta) * up;
      break;
    }
    case Kind::kEqualArea: {
      // Clarberg's square has the zenith in its middle, and right and ahead along its sides.
      const double a = 2 * at.x / size.x - 1, b = 2 * at.y / size.y - 1;
      const double height = 1 - std::abs(a) - std::abs(b), r = 1 - std::abs(height);
      const double phi = ((std::abs(b) - std::abs(a)) / r + 1) * kPi / 4;
      const double sine = r * std::sqrt(2 - r * r);
      dir = std::copysign(sine * std::cos(phi), a) * right +
            std::copysign(sine * std::sin(phi), b) * ahead + std::copysign(1 - r * r, height) * up;
      break;
    }
    case Kind::kFisheye: {
      const double radius = std::hypot(x, y), theta = radius * view.fov_degrees * kPi / 360;
      if (radius > 1) return 0;
      dir = std::cos(theta) * ahead + std::sin(theta) / radius * (x * right + y * up);
      break;
    }
  }
  if (view.lens_radius == 0) return Passes(from, dir);
  double sum = 0;
  constexpr int kRings = 6, kSectors = 18;
  for (int i = 0; i < kRings * kSectors; ++i) {
    const double r = view.lens_radius * std::sqrt((i / kSectors + 0.5) / kRings);
    const double turn = 2 * kPi * (i % kSectors + 0.5) / kSectors;
    const glm::dvec3 shift = r * (std::cos(turn) * right + std::sin(turn) * up);
    sum += Passes(from + shift, view.focal_distance * dir - shift);
  }
  return sum / (kRings * kSectors);
}

using CamerasCli = Program;

// No surface scatters, so all of them are black.
TEST_F(CamerasCli, EachViewSeesOrMissesTheTriangle) {
  Put("triangle.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  Image white(8, 4);
  for (float& value : white.rgb) value = 1;
  WriteExr(Path("white.exr"), white);
  const std::string eye = "--eye 0.3,0.2,2 ", target = "--target 0.3,0.2,0 ", fov = "--fov 50 ";
  const std::string usual = eye + target + fov;
  const View views[] = {
      {.options = usual},
      {.options = usual + "--camera orthographic", .kind = Kind::kOrthographic},
      {.options = usual + "--camera latlong", .kind = Kind::kLatLong},
      {.options = usual + "--camera equal-area", .kind = Kind::kEqualArea},
      {.options = eye + target + "--camera fisheye", .kind = Kind::kFisheye, .fov_degrees = 180},
      {.options = usual + "--camera fisheye", .kind = Kind::kFisheye},
      {.options = eye + target + "--fov 30", .fov_degrees = 30},
      {.options = target + fov + "--eye 1.3,1,2.5", .eye = {1.3, 1, 2.5}},
      {.options = eye + fov + "--target 0.8,0.3,0.5", .target = {0.8, 0.3, 0.5}},
      // The middle of the scene is sharp by itself.
      {.options = usual + "--lens-radius 0.3", .lens_radius = 0.3},
      {.options = usual + "--lens-radius 0.3 --focal-distance 1",
       .lens_radius = 0.3,
       .focal_distance = 1},
      {.options = usual + "--lens-radius 0.2 --focal-distance 1.2 --camera orthographic",
       .kind = Kind::kOrthographic,
       .lens_radius = 0.2,
       .focal_distance = 1.2}};
  for (const View& view : views) {
    SCOPED_TRACE(view.options);
    const bool square = view.kind == Kind::kEqualArea;
    const glm::dvec2 size(64, square ? 64 : 32);
    const Result result = Run("render triangle.ply --env white.exr --max-depth 0 --filter box " +
                              std::string(square ? "--size 64x64 " : "--size 64x32 ") +
                              "--spp 64 -q -o a.exr " + view.options);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Image picture = ReadImage(Path("a.exr"));
    ASSERT_EQ(picture.width, 64);
    double difference = 0, black = 0;
    constexpr int kSide = 6;  // points along each side of a pixel
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        double expected = 0;
        for (int i = 0; i < kSide * kSide; ++i) {
          const glm::dvec2 at(x + (i % kSide + 0.5) / kSide, y + (i / kSide + 0.5) / kSide);
          expected += LightAt(view, at, size) / (kSide * kSide);
        }
        const double off = std::abs(double(picture.Pixel(x, y)[1]) - expected);
        EXPECT_LT(off, 0.35) << x << ", " << y;
        difference += off / (size.x * size.y), black += 1 - expected;
      }
    }
    EXPECT_LT(difference, 0.004);
    EXPECT_GT(black, 8);
  }
}

}  // namespace
}  // namespace skywave
