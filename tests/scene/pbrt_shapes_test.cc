// Compares shapes of pbrt that become meshes with areas, extents and normals in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "base/files.h"
#include "scene/pbrt/reader.h"
#include "scene/shapes/patches.h"

namespace skywave {
namespace {

// Returns the mesh of a shape of which nothing is left out; hyperboloids may differ from pbrt's.
Mesh Shape(const std::string& shape) {
  const bool strict = shape.find("hyperboloid") == std::string::npos;
  return ParsePbrt("WorldBegin " + shape, "t.pbrt", {.strict = strict}).meshes.at(0);
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

// Expects every triangle to be wound to the side of its unit normals, and uvs in [0, 1].
void ExpectConsistent(const Mesh& mesh) {
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const glm::uvec3& t : mesh.triangles) {
    EXPECT_GT(glm::length(Cross(mesh, t)), 0);
    for (int corner = 0; corner < 3; ++corner) {
      EXPECT_GT(glm::dot(Cross(mesh, t), glm::dvec3(mesh.normals[t[corner]])), 0);
    }
  }
  for (const glm::vec3& n : mesh.normals) EXPECT_NEAR(glm::length(n), 1, 1e-6);
  for (const glm::vec2& uv : mesh.uvs) {
    EXPECT_TRUE(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1);
  }
}

// Of the surface from the apex to a rim of that radius and height.
double AreaOfParaboloid(double radius, double height) {
  const double a = height / (radius * radius);
  return M_PI / (6 * a * a) * (std::pow(1 + 4 * a * a * radius * radius, 1.5) - 1);
}

// The integral of |dp/du x dp/dv| by the midpoint rule.
double AreaOfHyperboloid(const glm::dvec3& p1, const glm::dvec3& p2) {
  const glm::dvec3 d = p2 - p1;
  double area = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const glm::dvec3 p = p1 + (i + 0.5) / kSteps * d;
    area += 2 * M_PI * std::hypot(std::hypot(p.x, p.y) * d.z, p.x * d.x + p.y * d.y) / kSteps;
  }
  return area;
}

TEST(RoundShapes, HaveTheirAreas) {
  // A zone of a sphere has the area phi r h. Cuts of 2 degrees lose at most 3e-4 of it.
  const struct {
    const char* shape;
    double area;
  } shapes[] = {
      {"Shape \"sphere\" \"float radius\" 2 \"float zmin\" -1 \"float zmax\" 1.5",
       2 * M_PI * 2 * 2.5},
      {"Shape \"sphere\" \"float radius\" 2 \"float phimax\" 90", M_PI / 2 * 2 * 4},
      {"Shape \"sphere\" \"float zmin\" .5 \"float zmax\" -.25 \"float phimax\" 200",
       200. / 180 * M_PI * 0.75},
      {"Shape \"disk\" \"float radius\" 3", M_PI * 9},
      {"Shape \"disk\" \"float radius\" 3 \"float innerradius\" 1 \"float phimax\" 45", M_PI},
      {"Shape \"cylinder\" \"float radius\" 2 \"float zmin\" -1 \"float zmax\" 3", 2 * M_PI * 8},
      {"Shape \"cylinder\" \"float phimax\" 60", M_PI / 3 * 2},
      {"Shape \"cone\" \"float radius\" 2 \"float height\" 3", M_PI * 2 * std::sqrt(13.0)},
      {"Shape \"cone\" \"float phimax\" 90", M_PI / 4 * std::sqrt(2.0)},
      {"Shape \"paraboloid\" \"float radius\" 2 \"float zmin\" .5 \"float zmax\" 2",
       AreaOfParaboloid(2, 2) - AreaOfParaboloid(1, 0.5)},
      {"Shape \"paraboloid\"", AreaOfParaboloid(1, 1)},
      {"Shape \"hyperboloid\" \"point p1\" [2 0 0] \"point p2\" [1 0 1]",
       M_PI * 3 * std::sqrt(2.0)},
      {"Shape \"hyperboloid\" \"point p1\" [1 0 0] \"point p2\" [.8 1 .8]",
       AreaOfHyperboloid({1, 0, 0}, {.8, 1, .8})},
      {"Shape \"hyperboloid\"", M_PI * std::sqrt(2.0) * std::sqrt(3.0)},
  };
  for (const auto& expected : shapes) {
    SCOPED_TRACE(expected.shape);
    const Mesh mesh = Shape(expected.shape);
    ExpectConsistent(mesh);
    EXPECT_NEAR(Area(mesh) / expected.area, 1, 5e-4);
    EXPECT_EQ(mesh.uvs.size(), mesh.positions.size());
  }
}

TEST(RoundShapes, AreOrientedAsInPbrt) {
  const Mesh sphere = Shape("Shape \"sphere\" \"float phimax\" 90");
  for (std::size_t i = 0; i < sphere.positions.size(); ++i) {
    const glm::vec3 p = sphere.positions[i];
    EXPECT_GE(p.x, -1e-6f);
    EXPECT_GE(p.y, -1e-6f);
    EXPECT_GT(glm::dot(sphere.normals[i], p), 0.999f);  // outwards
    EXPECT_NEAR(p.z, -std::cos(M_PI * sphere.uvs[i].y), 1e-5);
    if (std::abs(p.z) < 0.99f) {
      EXPECT_NEAR(std::atan2(p.y, p.x), M_PI / 2 * sphere.uvs[i].x, 1e-5);
    }
  }
  const Mesh disk = Shape("Shape \"disk\" \"float height\" 4 \"float innerradius\" .5");
  for (std::size_t i = 0; i < disk.positions.size(); ++i) {
    EXPECT_EQ(disk.positions[i].z, 4);
    EXPECT_EQ(disk.normals[i], glm::vec3(0, 0, 1));
    EXPECT_NEAR(glm::length(glm::vec2(disk.positions[i])), 1 - 0.5 * disk.uvs[i].y, 1e-6);
  }
  EXPECT_EQ(Shape("ReverseOrientation Shape \"disk\"").normals[0], glm::vec3(0, 0, -1));
  const Mesh cylinder = Shape("Shape \"cylinder\" \"float zmin\" 2 \"float zmax\" 1");
  for (std::size_t i = 0; i < cylinder.positions.size(); ++i) {
    EXPECT_NEAR(cylinder.positions[i].z, 1 + cylinder.uvs[i].y, 1e-6);
    EXPECT_EQ(cylinder.normals[i].z, 0);
  }
}

// Without textures a whole sphere has no poles; with textures it has coordinates.
// The equations of the surfaces, and normals as pbrt-v3's derivatives give them: a cone's lean
// upwards, a paraboloid's downwards.
TEST(RoundShapes, OfVersion3LieOnTheirSurfaces) {
  const Mesh cone = Shape("Shape \"cone\" \"float radius\" 2 \"float height\" 3");
  for (std::size_t i = 0; i < cone.positions.size(); ++i) {
    const glm::vec3 p = cone.positions[i], n = cone.normals[i];
    EXPECT_NEAR(std::hypot(p.x, p.y), 2 - 2 * p.z / 3, 1e-6);
    EXPECT_NEAR(n.z, 2 / std::sqrt(13.0), 1e-6);
    EXPECT_NEAR(cone.uvs[i].y, p.z / 3, 1e-6);
  }
  const Mesh bowl = Shape("Shape \"paraboloid\" \"float radius\" 2 \"float zmax\" 3");
  for (std::size_t i = 0; i < bowl.positions.size(); ++i) {
    const glm::vec3 p = bowl.positions[i], n = bowl.normals[i];
    EXPECT_NEAR(p.z, 3 * (p.x * p.x + p.y * p.y) / 4, 1e-5);
    // The gradient of 3 (x^2 + y^2) / 4 - z.
    const glm::vec3 gradient = glm::normalize(glm::vec3(1.5f * p.x, 1.5f * p.y, -1));
    EXPECT_NEAR(glm::dot(n, gradient), 1, 1e-5);
    EXPECT_NEAR(bowl.uvs[i].y, p.z / 3, 1e-6);
  }
  // One of its straight lines is that from p1 to p2.
  const Mesh waist = Shape("Shape \"hyperboloid\" \"point p1\" [1 0 0] \"point p2\" [.8 1 .8]");
  for (std::size_t i = 0; i < waist.positions.size(); ++i) {
    const glm::vec3 p = waist.positions[i];
    const double v = waist.uvs[i].y, x = 1 - 0.2 * v;
    EXPECT_NEAR(p.z, 0.8 * v, 1e-6);
    EXPECT_NEAR(p.x * p.x + p.y * p.y, x * x + v * v, 1e-5);
  }
}

// pbrt-v3 intersects the surface of the line only where that is thinnest at z = 0.
TEST(RoundShapes, AHyperboloidThatPbrtHasOtherwiseIsReported) {
  const auto warnings = [](const std::string& points) {
    return ParsePbrt("WorldBegin Shape \"hyperboloid\" " + points, "t.pbrt").warnings;
  };
  EXPECT_TRUE(warnings("").empty());
  EXPECT_TRUE(warnings("\"point p1\" [.6 .6 .6] \"point p2\" [.6 -.6 -.6]").empty());
  EXPECT_TRUE(warnings("\"point p1\" [1 0 0] \"point p2\" [1 1 .8]").empty());
  for (const char* const other :
       {"\"point p1\" [1 0 0] \"point p2\" [.8 1 .8]", "\"point p1\" [2 0 0] \"point p2\" [1 0 1]",
        "\"point p1\" [1 0 1] \"point p2\" [2 0 1]"}) {
    const std::vector<std::string> said = warnings(other);
    ASSERT_EQ(said.size(), 1u) << other;
    EXPECT_NE(said[0].find("pbrt-v3 intersects another surface"), std::string::npos) << said[0];
  }
}

TEST(RoundShapes, ThatMakeNoSurfaceAreRefused) {
  for (const char* const shape :
       {"\"cone\" \"float height\" 0", "\"paraboloid\" \"float zmin\" -1",
        "\"hyperboloid\" \"point p1\" [1 1 1]", "\"heightfield\" \"integer nu\" 2",
        "\"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 1 2]"}) {
    EXPECT_THROW(Shape(std::string("Shape ") + shape), InputError) << shape;
  }
}

TEST(Heightfield, IsFlatTrianglesOverTheUnitSquare) {
  const Mesh mesh =
      Shape("Shape \"heightfield\" \"integer nu\" 3 \"integer nv\" 2 \"float Pz\" [0 1 2 3 4 5]");
  ASSERT_EQ(mesh.positions.size(), 6u);
  EXPECT_EQ(mesh.positions[4], glm::vec3(0.5f, 1, 4));
  EXPECT_TRUE(mesh.normals.empty());
  ASSERT_EQ(mesh.triangles.size(), 4u);
  for (const glm::uvec3& t : mesh.triangles) EXPECT_GT(Cross(mesh, t).z, 0);
}

TEST(RoundShapes, WholeSpheresHaveCoordinatesWhereTexturesAre) {
  EXPECT_TRUE(Shape("Shape \"sphere\"").uvs.empty());
  const Mesh mesh = Shape("Texture \"c\" \"color\" \"checkerboard\" Shape \"sphere\"");
  ExpectConsistent(mesh);
  EXPECT_NEAR(Area(mesh) / (4 * M_PI), 1, 5e-4);
}

// The grain of an anisotropic metal follows (u, v), so a sphere of it needs them.
TEST(RoundShapes, WholeSpheresHaveCoordinatesWhereTheGrainFollowsThem) {
  const std::string metal =
      "\"conductor\" \"float uroughness\" .02 \"float vroughness\" .3 "
      "\"bool remaproughness\" false ";
  EXPECT_FALSE(Shape("Material " + metal + "Shape \"sphere\"").uvs.empty());
  EXPECT_FALSE(Shape("MakeNamedMaterial \"a\" \"string type\" " + metal +
                     "MakeNamedMaterial \"b\" \"string type\" \"diffuse\" "
                     "Material \"mix\" \"string materials\" [\"b\" \"a\"] Shape \"sphere\"")
                   .uvs.empty());
}

TEST(BilinearMesh, IsExactAndCutOnlyWhereItBends) {
  const Mesh flat = Shape("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 1 3 0 3 3 0]");
  EXPECT_EQ(flat.triangles.size(), 2u);
  EXPECT_NEAR(Area(flat), 6, 1e-6);
  EXPECT_EQ(flat.normals[0], glm::vec3(0, 0, 1));
  // z = x y is an exact bilinear surface: vertices lie on it and have its normals.
  const Mesh saddle = Shape(
      "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1 2 0 0 2 1 2] "
      "\"integer indices\" [0 1 2 3  1 4 3 5]");
  ASSERT_EQ(saddle.triangles.size(), std::size_t(2 * 2 * kBilinearSteps * kBilinearSteps));
  ExpectConsistent(saddle);
  for (std::size_t i = 0; i < saddle.positions.size(); ++i) {
    const glm::vec3 p = saddle.positions[i];
    EXPECT_NEAR(p.z, p.x * p.y, 1e-6);
    const glm::vec3 normal = glm::normalize(glm::vec3(-p.y, -p.x, 1));
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(saddle.normals[i][axis], normal[axis], 1e-5);
  }
  // Given normals determine the side.
  const Mesh turned = Shape(
      "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] "
      "\"normal N\" [0 0 -1 0 0 -1 0 0 -1 0 0 -1]");
  ExpectConsistent(turned);
  EXPECT_EQ(turned.normals[0], glm::vec3(0, 0, -1));
}

// The patch is a flat unit square, so that positions give u and v of the patch.
TEST(BilinearMesh, IsCutWhereItsCoordinatesBend) {
  const Mesh mesh = Shape(
      "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] "
      "\"point2 uv\" [0 0 1 0 0 1 .5 .5]");
  ASSERT_EQ(mesh.triangles.size(), std::size_t(2 * kBilinearSteps * kBilinearSteps));
  ExpectConsistent(mesh);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const float x = mesh.positions[i].x, y = mesh.positions[i].y;
    EXPECT_NEAR(mesh.uvs[i].x, x * (1 - y) + 0.5f * x * y, 1e-6);
    EXPECT_NEAR(mesh.uvs[i].y, y * (1 - x) + 0.5f * x * y, 1e-6);
  }
}

}  // namespace
}  // namespace skywave
