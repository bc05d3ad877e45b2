// Compares pbrt's curves with cylinders, tori, helicoids and splines in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "base/error.h"
#include "scene/pbrt/reader.h"
#include "scene/shapes/curves.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/render_scenes.h"

namespace skywave {
namespace {

constexpr double kPi = 3.14159265358979324;

// A texture makes coordinates necessary.
const std::string kWithUvs = "WorldBegin Texture \"c\" \"spectrum\" \"checkerboard\" ";

// Curves are cylinders unless they say something else. Only flat ones are not quite what they say.
Mesh Curve(const std::string& parameters, const std::string& before = kWithUvs) {
  const bool has_type = parameters.find("string type") != std::string::npos;
  const bool flat = parameters.find("flat") != std::string::npos;
  return ParsePbrt(before + "Shape \"curve\" " + (has_type ? "" : "\"string type\" \"cylinder\" ") +
                       parameters,
                   "t.pbrt", {.strict = !flat})
      .meshes.at(0);
}

TEST(Curves, FlatCurvesAreReportedOnce) {
  const std::string curve = "\nShape \"curve\" \"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3]";
  const Scene scene = ParsePbrt("WorldBegin" + curve + curve, "t.pbrt");
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(scene.warnings[0].starts_with("t.pbrt:2: a curve of the type \"flat\""));
  EXPECT_TRUE(scene.warnings[0].ends_with("(2 times)"));
}

glm::dvec3 Cross(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a = mesh.positions[t.x];
  return glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a);
}

double Area(const Mesh& mesh) {
  double area = 0;
  for (const glm::uvec3& t : mesh.triangles) area += 0.5 * glm::length(Cross(mesh, t));
  return area;
}

// Expects unit normals on the side to which the triangles are wound.
void ExpectConsistent(const Mesh& mesh) {
  ASSERT_FALSE(mesh.triangles.empty());
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-6);
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      ASSERT_GT(glm::dot(Cross(mesh, t), glm::dvec3(mesh.normals[t[i]])), 0);
    }
  }
}

// Edges of a tube with so many sides are that much farther out than its radius.
double Reach(int sides) { return kPi / sides / std::sin(kPi / sides); }

TEST(Curves, StraightCurvesAreCylinders) {
  for (const char* type : {"flat", "cylinder"}) {
    const Mesh mesh = Curve(
        "\"point3 P\" [1 2 3 1 2 4 1 2 5 1 2 6] \"float width\" .6 \"string "
        "type\" \"" +
        std::string(type) + "\"");
    ExpectConsistent(mesh);
    EXPECT_NEAR(Area(mesh) / (kPi * 0.6 * 3), 1, 1e-5);
    const int sides = 2 * int(std::ceil(kMaxTubeSides * std::sqrt(0.6 / 3) / 2));
    EXPECT_EQ(mesh.triangles.size(), std::size_t(2 * sides));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const glm::dvec2 away = glm::dvec2(mesh.positions[i]) - glm::dvec2(1, 2);
      EXPECT_NEAR(glm::length(away), 0.3 * Reach(sides), 1e-6);
      EXPECT_LT(glm::length(glm::dvec3(mesh.normals[i]) - glm::dvec3(glm::normalize(away), 0)),
                1e-6);
      EXPECT_NEAR(mesh.uvs[i].x, (mesh.positions[i].z - 3) / 3, 1e-6);
    }
  }
}

// Opposite places have v and 1 - v.
TEST(Curves, HaveCoordinatesThatGoRoundAndBack) {
  const Mesh mesh = Curve("\"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3]");
  int opposites = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    for (std::size_t k = 0; k < mesh.positions.size(); ++k) {
      const glm::vec3 opposite(-mesh.positions[k].x, -mesh.positions[k].y, mesh.positions[k].z);
      if (glm::length(mesh.positions[i] - opposite) > 1e-5f) continue;
      ASSERT_NEAR(mesh.uvs[i].y, 1 - mesh.uvs[k].y, 1e-6);
      ++opposites;
    }
  }
  EXPECT_GE(opposites, int(mesh.positions.size()));
  // v grows evenly with the angle from 0 to 1 and back; it is 0 and 1 somewhere.
  const auto least = std::min_element(mesh.uvs.begin(), mesh.uvs.end(),
                                      [](auto& a, auto& b) { return a.y < b.y; });
  const glm::vec3 zero = mesh.positions[std::size_t(least - mesh.uvs.begin())];
  double most = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::dvec2 at(mesh.positions[i]), from(zero);
    const double turn = std::acos(
        std::clamp(glm::dot(at, from) / (glm::length(at) * glm::length(from)), -1.0, 1.0));
    ASSERT_NEAR(mesh.uvs[i].y, turn / kPi, 1e-3);
    most = std::max(most, double(mesh.uvs[i].y));
  }
  EXPECT_EQ(least->y, 0);
  EXPECT_EQ(most, 1);
  EXPECT_TRUE(Curve("\"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3]", "WorldBegin ").uvs.empty());
}

// A Bezier curve with these control points is within 2.73e-4 of a quarter of a circle.
TEST(Curves, AQuarterOfACircleIsAQuarterOfATorus) {
  const Mesh mesh = Curve(
      "\"point3 P\" [1 0 0 1 .5522847498 0 .5522847498 1 0 0 1 0] \"float width\" .2 "
      "\"string type\" \"cylinder\"");
  ExpectConsistent(mesh);
  EXPECT_NEAR(Area(mesh) / (kPi / 2 * kPi * 0.2), 1, 1e-3);
  double least = 1, most = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::dvec3 p = mesh.positions[i];
    const glm::dvec3 centre(glm::normalize(glm::dvec2(p)), 0);
    const double distance = glm::distance(p, centre);
    least = std::min(least, distance), most = std::max(most, distance);
    const glm::dvec3 outside = (p - centre) / distance;
    ASSERT_LT(glm::length(outside - glm::dvec3(mesh.normals[i])), 5e-3);
  }
  const int sides = 2 * int(std::ceil(kMaxTubeSides * std::sqrt(0.2 / 1.6568542) / 2));
  EXPECT_GT(least, 0.1 * Reach(sides) - 2.8e-4);
  EXPECT_LT(most, 0.1 * Reach(sides) + 2.8e-4);
}

// The area of a cone between circles is that of a trapezoid, and its normals lean by its slope.
TEST(Curves, TaperedCurvesAreCones) {
  const Mesh mesh =
      Curve("\"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3] \"float width0\" 2 \"float width1\" 0");
  ExpectConsistent(mesh);
  const double slant = std::hypot(3, 1);
  EXPECT_NEAR(Area(mesh) / (kPi * slant), 1, 1e-3);
  for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(n.z, 1 / slant, 1e-6);
  // The segments of one curve share its width.
  const Mesh two = Curve(
      "\"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 5 0 0 6] \"float width0\" 2 \"float "
      "width1\" 1");
  double there = 0;
  for (const glm::vec3& p : two.positions) {
    if (std::abs(p.z - 3) < 1e-5) there = std::max(there, double(std::hypot(p.x, p.y)));
  }
  EXPECT_NEAR(there, 0.75, 0.01);
  EXPECT_NEAR(Area(two) / (kPi * 1.5 * std::hypot(6, .5)), 1, 1e-3);
}

// A ribbon that turns by a right angle is a piece of a helicoid: (x, v cos a, v sin a).
TEST(Curves, RibbonsTurnWithTheirNormals) {
  const Mesh mesh = Curve(
      "\"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"normal N\" [0 0 2 0 -1 0] \"string type\" "
      "\"ribbon\" \"float width\" 1.5");
  ExpectConsistent(mesh);
  const double pitch = kPi / 2 / 3, half = 0.75;
  const double expected =
      3 * (half * std::hypot(1, pitch * half) + std::asinh(pitch * half) / pitch);
  EXPECT_NEAR(Area(mesh) / expected, 1, 1e-3);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::dvec3 p = mesh.positions[i], n = mesh.normals[i];
    const double angle = p.x * pitch;
    EXPECT_NEAR(mesh.uvs[i].x, p.x / 3, 1e-6);
    const glm::dvec3 normal(0, -std::sin(angle), std::cos(angle));
    EXPECT_LT(glm::length(n - normal), 1e-5);
    // v grows along tangent x normal.
    const glm::dvec3 across = glm::cross(glm::dvec3(1, 0, 0), normal);
    EXPECT_LT(glm::length(p - glm::dvec3(p.x, 0, 0) - (mesh.uvs[i].y - 0.5) * 1.5 * across), 1e-5);
  }
}

// Returns the point of a uniform B-spline by its recursion (Cox and de Boor) at t in knots.
glm::dvec3 BSpline(const std::vector<glm::dvec3>& points, int degree, double t) {
  const auto basis = [&](const auto& self, int i, int k) -> double {
    if (k == 0) return t >= i && t < i + 1 ? 1 : 0;
    return (t - i) / k * self(self, i, k - 1) + (i + k + 1 - t) / k * self(self, i + 1, k - 1);
  };
  glm::dvec3 sum(0);
  for (int i = 0; i < int(points.size()); ++i) {
    sum += basis(basis, i, degree) * points[std::size_t(i)];
  }
  return sum;
}

// The two edges of a ribbon have the curve between them.
TEST(Curves, BasesAndDegreesAreTheirFormulae) {
  const std::vector<glm::dvec3> points = {{0, 0, 0}, {1, 2, 0}, {2, -1, 0}, {4, 1, 0}, {5, 0, 0}};
  const std::string list = "\"point3 P\" [0 0 0 1 2 0 2 -1 0 4 1 0 5 0 0] ";
  const std::string ribbon = "\"string type\" \"ribbon\" \"float width\" .1 ";
  for (const int degree : {2, 3}) {
    for (const bool spline : {false, true}) {
      if (!spline && degree == 3) continue;
      SCOPED_TRACE(testing::Message() << degree << spline);
      const int segments = spline ? 5 - degree : 2;
      std::string normals;
      for (int i = 0; i <= segments; ++i) normals += "0 0 1 ";
      const Mesh mesh = Curve(list + ribbon + "\"normal N\" [" + normals + "] \"integer degree\" " +
                              std::to_string(degree) + " \"string basis\" \"" +
                              (spline ? "bspline" : "bezier") + "\"");
      // Vertices are those of one edge of a segment and then of the other.
      std::size_t i = 0;
      for (int segment = 0; segment < segments; ++segment) {
        std::size_t end = i + 1;
        while (mesh.uvs[end].x > mesh.uvs[end - 1].x) ++end;
        const std::size_t edge = end - i;
        ASSERT_GT(edge, 4u);
        for (std::size_t k = i; k < end; ++k) {
          const double u = mesh.uvs[k].x, s = 1 - u;
          const glm::dvec3 middle =
              0.5 * (glm::dvec3(mesh.positions[k]) + glm::dvec3(mesh.positions[k + edge]));
          const std::size_t first = 2 * std::size_t(segment);
          const glm::dvec3 expected =
              spline ? BSpline(points, degree, segment + degree + std::min(u, 1 - 1e-12))
                     : s * s * points[first] + 2 * s * u * points[first + 1] +
                           u * u * points[first + 2];
          ASSERT_LT(glm::length(middle - expected), 1e-5) << segment << " " << u;
        }
        i += 2 * edge;
      }
      EXPECT_EQ(i, mesh.positions.size());
    }
  }
}

// Every point of a curve is near the chords into which it is cut.
TEST(Curves, AreCutFinely) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 200; ++trial) {
    CurveSegment segment;
    for (glm::dvec3& p : segment.points) p = {uniform(random), uniform(random), uniform(random)};
    const double width = std::pow(10, uniform(random) - 2);
    segment.widths = {width, width / 2};
    segment.normals = {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, 1)};
    const std::size_t triangles = CurveTriangles({&segment, 1}, CurveForm::kRibbon);
    const Mesh mesh = TessellateCurve({&segment, 1}, CurveForm::kRibbon);
    ASSERT_LE(mesh.triangles.size(), triangles);
    const std::size_t edge = mesh.positions.size() / 2;
    ASSERT_EQ(triangles, 2 * (edge - 1));
    const auto middle = [&](std::size_t k) {
      return 0.5 * (glm::dvec3(mesh.positions[k]) + glm::dvec3(mesh.positions[k + edge]));
    };
    for (std::size_t k = 0; k + 1 < edge; ++k) {
      for (const double part : {0.25, 0.5, 0.75}) {
        const double u = (double(k) + part) / double(edge - 1), s = 1 - u;
        const auto& p = segment.points;
        const glm::dvec3 at =
            s * s * s * p[0] + 3 * s * s * u * p[1] + 3 * s * u * u * p[2] + u * u * u * p[3];
        const glm::dvec3 chord = middle(k + 1) - middle(k);
        const double along =
            std::clamp(glm::dot(at - middle(k), chord) / glm::dot(chord, chord), 0.0, 1.0);
        ASSERT_LT(glm::distance(at, middle(k) + along * chord), kCurveTolerance * width + 1e-6);
      }
    }
  }
}

// Hair ends in points that are given twice; a curve may also turn back, or be a point.
TEST(Curves, RepeatedControlPointsAreTessellated) {
  for (const char* points :
       {"0 0 0 0 0 0 1 0 0 1 0 0", "0 0 0 1 0 0 1 0 0 0 0 0", "0 0 0 0 0 0 0 0 0 0 1 0",
        "0 0 0 0 0 0 0 0 0 0 0 0 1 0 0 2 0 0 3 0 0"}) {
    SCOPED_TRACE(points);
    const Mesh mesh = Curve("\"point3 P\" [" + std::string(points) + "] \"float width\" .01");
    EXPECT_FALSE(mesh.triangles.empty());
    for (const glm::vec3& p : mesh.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
    for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-5);
  }
  EXPECT_TRUE(Curve("\"point3 P\" [1 2 3 1 2 3 1 2 3 1 2 3]").triangles.empty());
}

TEST(Curves, AreBounded) {
  CurveSegment segment;
  segment.points = {glm::dvec3(0), {9e9, 0, 0}, {0, 9e9, 0}, {5, 5, 5}};
  segment.widths = {1e-30, 1e-30};
  const std::size_t most = std::size_t(2 * kMaxCurvePieces * kMinTubeSides);
  EXPECT_EQ(CurveTriangles({&segment, 1}, CurveForm::kTube), most);
  // The rings of wider ones have an area, so that none of these triangles is left out.
  segment.points = {glm::dvec3(0), {900, 0, 0}, {0, 900, 0}, {5, 5, 5}};
  segment.widths = {1e-3, 1e-3};
  EXPECT_EQ(CurveTriangles({&segment, 1}, CurveForm::kTube), most);
  EXPECT_EQ(TessellateCurve({&segment, 1}, CurveForm::kTube).triangles.size(), most);
  try {
    ParsePbrt("WorldBegin\n\nShape \"curve\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]", "t.pbrt",
              {.max_triangles = 300});
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("t.pbrt:3: ")) << error.what();
    EXPECT_NE(std::string(error.what()).find("more than 300 triangles"), std::string::npos);
  }
}

// White hair nearly vanishes in a furnace, seen from so near that it fills the film.
TEST(Curves, ThinCurvesLoseLittleLight) {
  const RenderJob job(
      ParsePbrt(
          "LookAt 0 0 1 0 0 0 0 1 0 Camera \"orthographic\" \"float screenwindow\" [-.0024 "
          ".0024 -.0024 .0024] WorldBegin LightSource \"infinite\" Material \"diffuse\" \"rgb "
          "reflectance\" [1 1 1] Shape \"curve\" \"point3 P\" [0 -.5 0 0 -.2 0 0 .2 0 0 .5 0] "
          "\"float width\" .005",
          "t.pbrt"),
      SmallRequest(24, 24, 64));
  const PictureEstimate picture = MeanOfBlocks(EstimateFromEngine(job, 4, 60), 24);
  for (const double mean : picture.mean) {
    EXPECT_GT(mean, 0.993);
    EXPECT_LT(mean, 1);
  }
}

// A thick tube and pbrt's cylinder, whose sides are finer, are the same picture.
TEST(Curves, LookLikeCylinders) {
  const std::string scene =
      "LookAt 1 3 4 0 0 0 0 0 1 Camera \"perspective\" \"float fov\" 40 WorldBegin\n"
      "LightSource \"distant\" \"point3 from\" [1 2 3]\n"
      "LightSource \"infinite\" \"rgb L\" [.2 .3 .4]\n"
      "Material \"diffuse\" \"rgb reflectance\" [.7 .6 .5]\n";
  const auto picture = [&](const std::string& shape, std::uint32_t seed) {
    const RenderJob job(ParsePbrt(scene + shape, "t.pbrt", {.strict = true}),
                        SmallRequest(24, 24, 16));
    return EstimateFromEngine(job, 8, seed);
  };
  const PictureEstimate cylinder = picture("Shape \"cylinder\" \"float radius\" .5", 1);
  const std::string points =
      "Shape \"curve\" \"point3 P\" [0 0 -1 0 0 -.4 0 0 .3 0 0 1] \"string type\" \"cylinder\" ";
  EXPECT_TRUE(SamePicture(cylinder, picture(points + "\"float width\" 1", 20), 1e-4));
  EXPECT_FALSE(SamePicture(cylinder, picture(points + "\"float width\" .95", 40), 1e-4));
}

}  // namespace
}  // namespace skywave
