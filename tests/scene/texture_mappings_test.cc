// Tests textures by how they lie: dots over (u, v), and mappings that go by the place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "scene/materials/noise.h"
#include "scene/pbrt/reader.h"
#include "tests/support/baked_places.h"

namespace skywave {
namespace {

// The plane of the checks is spanned by two vectors of the texture's space, which is turned.
TEST(TextureMappings, PlanarMappingsPlaceChecks) {
  const Scene scene = ParseAll(
      "AttributeBegin Rotate 90 0 0 1 Texture \"c\" \"spectrum\" \"checkerboard\" \"string "
      "mapping\" \"planar\" \"vector3 v1\" [2 0 0] \"vector3 v2\" [0 1.5 1] \"float udelta\" .3 "
      "\"rgb tex1\" [1 .5 0] \"rgb tex2\" [0 0 1] AttributeEnd Material \"diffuse\" \"texture "
      "reflectance\" \"c\" Shape \"sphere\"");
  const std::vector<Place> places = Places(scene, 1);
  EXPECT_GT(places.size(), 2000u);
  ExpectChecks(places, 0.05, {1, .5f, 0}, {0, 0, 1}, [](const Place& place) {
    // The turn takes x to y, and y to -x.
    const glm::dvec3 p(place.position.y, -place.position.x, place.position.z);
    return glm::dvec2(2 * p.x + 0.3, 1.5 * p.y + p.z);
  });
}

// The angle around the z axis of the texture's space [turns, from 0 to 1], and its other
// coordinates: the polar angle [half turns], the height, and that on the unit sphere.
struct RoundPlace {
  double turn, polar, height, unit_height;
};
RoundPlace Around(const Place& place) {
  // The space is turned by a quarter: its z is -y, its y is z.
  const glm::dvec3 p = (glm::dvec3(place.position) - glm::dvec3(.1, 0, .2)) / 2.0;
  const double angle = std::atan2(p.z, p.x) / (2 * 3.14159265358979);
  const double length = glm::length(p), height = -p.y;
  return {angle < 0 ? angle + 1 : angle, std::acos(height / length) / 3.14159265358979, height,
          height / length};
}

// Four colours show u in red and v in green, from 0 to 1. As in pbrt-v4, u of a sphere is its polar
// angle, and v of a cylinder the height, which is that of the unit sphere in pbrt-v3.
TEST(TextureMappings, LieAroundAnAxis) {
  const auto places = [](const std::string& mapping, const char* shape, const char* end) {
    return Places(ParseAll("AttributeBegin Translate .1 0 .2 Scale 2 2 2 Rotate 90 1 0 0 Texture "
                           "\"t\" \"spectrum\" \"bilerp\" \"string mapping\" \"" +
                           mapping +
                           "\" \"rgb v00\" [0 0 1] \"rgb v10\" [1 0 1] \"rgb v01\" [0 1 1] "
                           "\"rgb v11\" [1 1 1] AttributeEnd Material \"diffuse\" \"texture "
                           "reflectance\" \"t\" " +
                           shape + end),
                  shape == std::string("Shape \"sphere\"") ? 1 : 1500);
  };
  for (const char* shape : {"Shape \"sphere\"",
                            "Shape \"trianglemesh\" \"point3 P\" [-2 -1.9 1.3 2 -1.5 1.2 1 .5 -2.9 "
                            "-1 1.2 -1.4] \"integer indices\" [0 1 2 0 2 3]"}) {
    SCOPED_TRACE(shape);
    int seen = 0;
    const auto near_seam = [](double turn) { return std::abs(turn - std::round(turn)) < 0.03; };
    for (const Place& place : places("spherical", shape, "")) {
      const RoundPlace at = Around(place);
      if (near_seam(at.turn) || at.polar < 0.1 || at.polar > 0.9) continue;
      ++seen;
      ASSERT_NEAR(place.color.x, at.polar, 0.01);
      ASSERT_NEAR(place.color.y, at.turn, 0.01);
    }
    EXPECT_GT(seen, 1000);
    for (const bool v3 : {false, true}) {
      int above = 0;
      for (const Place& place : places("cylindrical", shape, v3 ? " WorldEnd" : "")) {
        const RoundPlace at = Around(place);
        const double u = at.turn < 0.5 ? at.turn + 0.5 : at.turn - 0.5;
        if (near_seam(u) || at.polar < 0.1 || at.polar > 0.9) continue;
        const double v = v3 ? at.unit_height : at.height;
        above += v > 0.1;
        ASSERT_NEAR(place.color.x, u, 0.01);
        ASSERT_NEAR(place.color.y, Clamped(v), 0.01);
      }
      EXPECT_GT(above, 300);
    }
  }
}

// Dots are disks of radius 0.35, each within its cell around whole numbers.
TEST(Dots, AreDisksInCells) {
  constexpr int kCells = 24, kSteps = 40;
  int dots = 0;
  for (int cell = 0; cell < kCells * kCells; ++cell) {
    const glm::dvec2 middle(cell % kCells - 7, cell / kCells - 9);
    double inside = 0;
    glm::dvec2 sum(0);
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const glm::dvec2 at = (glm::dvec2(i % kSteps, i / kSteps) + 0.5) / double(kSteps) - 0.5;
      if (!IsInDot(middle + at)) continue;
      ++inside, sum += at;
    }
    if (inside == 0) continue;
    ++dots;
    ASSERT_NEAR(inside / (kSteps * kSteps), 3.14159265 * 0.35 * 0.35, 0.01);
    const glm::dvec2 centre = sum / inside;
    ASSERT_LE(std::max(std::abs(centre.x), std::abs(centre.y)), 0.15 + 1e-3);
  }
  EXPECT_GT(dots, kCells * kCells / 3);
  EXPECT_LT(dots, 2 * kCells * kCells / 3);
}

// Colours are where pbrt has them, whatever their names say: "inside" is that of the ground.
TEST(Dots, LieOverTheUnitSquare) {
  const Scene scene = ParseAll(
      "Texture \"d\" \"spectrum\" \"dots\" \"float uscale\" 5 \"float vscale\" 8 \"float udelta\" "
      "2 \"rgb inside\" [.9 .5 .1] \"rgb outside\" [.1 .2 .3] Material \"diffuse\" \"texture "
      "reflectance\" \"d\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"point2 uv\" "
      "[0 0 1 0 0 1]");
  int differ = 0, inside = 0;
  const std::vector<Place> places = Places(scene, 4000);
  for (const Place& place : places) {
    const bool dot = IsInDot({place.position.x * 5 + 2, place.position.y * 8});
    const glm::vec3 expected = dot ? glm::vec3(.1f, .2f, .3f) : glm::vec3(.9f, .5f, .1f);
    inside += dot, differ += glm::length(place.color - expected) > 0.01f;
  }
  EXPECT_GT(inside, 400);
  EXPECT_LT(differ, 100);  // at the rims of dots, a texel wide
}

}  // namespace
}  // namespace skywave
