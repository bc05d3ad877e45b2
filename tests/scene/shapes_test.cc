// Tessellated shapes are closed, wound outwards and smooth; Loop subdivision converges to its
// limit.
#include "scene/shapes/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/constants.hpp>
#include <map>
#include <utility>
#include <vector>

#include "scene/shapes/loop_subdivision.h"
#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

// Counts edges by their number of triangles, taking the direction into account: a closed,
// consistently wound surface has each directed edge once and its reverse once.
struct EdgeCounts {
  int paired = 0, single = 0, wrong = 0;
};
EdgeCounts CountEdges(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++directed[{t[i], t[(i + 1) % 3]}];
  }
  EdgeCounts counts;
  for (const auto& [edge, count] : directed) {
    const auto reverse = directed.find({edge.second, edge.first});
    const int back = reverse == directed.end() ? 0 : reverse->second;
    if (count != 1 || back > 1) {
      ++counts.wrong;
    } else {
      ++(back == 1 ? counts.paired : counts.single);
    }
  }
  return counts;
}

double Volume(const Mesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    sum += glm::dot(glm::dvec3(mesh.positions[t.x]),
                    glm::cross(glm::dvec3(mesh.positions[t.y]), glm::dvec3(mesh.positions[t.z])));
  }
  return sum / 6;
}

void ExpectClosedAndSmooth(const Mesh& mesh, double volume, double tolerance) {
  const EdgeCounts edges = CountEdges(mesh);
  EXPECT_GT(edges.paired, 0);
  EXPECT_EQ(edges.single, 0);
  EXPECT_EQ(edges.wrong, 0);
  EXPECT_NEAR(Volume(mesh) / volume, 1, tolerance);
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-5);
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 normal = glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                        mesh.positions[t.z] - mesh.positions[t.x]);
    ASSERT_GT(glm::length(normal), 0);
    for (int i = 0; i < 3; ++i) ASSERT_GT(glm::dot(normal, mesh.normals[t[i]]), 0);
  }
}

TEST(Shapes, SphereIsGeodesic) {
  for (const int frequency : {1, 2, 5, kSphereFrequency}) {
    const Mesh sphere = Sphere(2, frequency);
    EXPECT_EQ(sphere.triangles.size(), 20u * frequency * frequency);
    EXPECT_EQ(sphere.positions.size(), 10u * frequency * frequency + 2);
    for (std::size_t i = 0; i < sphere.positions.size(); ++i) {
      ASSERT_NEAR(glm::length(sphere.positions[i]), 2, 1e-6);
      ASSERT_NEAR(glm::distance(sphere.normals[i] * 2.0f, sphere.positions[i]), 0, 1e-6);
    }
  }
  ExpectClosedAndSmooth(Sphere(2), 4.0 / 3 * glm::pi<double>() * 8, 1e-3);
}

TEST(Shapes, BoxTorusAndRevolvedProfileAreClosed) {
  ExpectClosedAndSmooth(RoundedBox({1, 2, 3}, 0.01f, 3), 48, 1e-3);
  // Rounded all over, the box is a sphere.
  const Mesh round = RoundedBox(glm::vec3(1), 0.999f, 32);
  EXPECT_NEAR(Volume(round), 4.0 / 3 * glm::pi<double>(), 0.02);
  const double pi = glm::pi<double>();
  ExpectClosedAndSmooth(TorusKnot(1, 0, 2, 0, 0.5f, 96, 48), 2 * pi * 2 * pi * 0.25, 0.01);
  // A thin tube's volume is its length times its cross section.
  const Mesh knot = TorusKnot(2, 3, 1, 0.4f, 0.05f, 600, 24);
  double length = 0;
  const auto centre = [](double t) {
    const double r = 1 + 0.4 * std::cos(3 * t);
    return glm::dvec3(r * std::cos(2 * t), 0.4 * std::sin(3 * t), -r * std::sin(2 * t));
  };
  for (int i = 0; i < 10000; ++i) {
    length += glm::distance(centre(2 * pi * i / 10000), centre(2 * pi * (i + 1) / 10000));
  }
  ExpectClosedAndSmooth(knot, length * pi * 0.05 * 0.05, 0.02);

  std::vector<glm::vec2> half_circle = {{0, -1}};
  for (int i = 1; i < 64; ++i) {
    const double angle = pi * i / 64;
    half_circle.emplace_back(std::sin(angle), -std::cos(angle));
  }
  half_circle.emplace_back(0, 1);
  const Mesh ball = Revolve(half_circle, 128);
  ExpectClosedAndSmooth(ball, 4.0 / 3 * pi, 5e-3);
  for (std::size_t i = 0; i < ball.positions.size(); ++i) {
    ASSERT_GT(glm::dot(ball.positions[i], ball.normals[i]), 0.999);
  }
}

TEST(Shapes, DisplacedSphereStaysClosed) {
  Mesh blob = Sphere(1, 8);
  Displace(blob, [](const glm::vec3& p) { return 0.1f * std::sin(5 * p.x); });
  const EdgeCounts edges = CountEdges(blob);
  EXPECT_EQ(edges.single + edges.wrong, 0);
  float longest = 0;
  for (const glm::vec3& p : blob.positions) longest = std::max(longest, glm::length(p));
  EXPECT_GT(longest, 1.09f);
}

TEST(Mesh, TransformKeepsTheOutside) {
  Mesh sphere = Sphere(1, 4);
  const double volume = Volume(sphere);
  const glm::dmat4 mirror(glm::dvec4(-2, 0, 0, 0), glm::dvec4(0.5, 1, 0, 0), glm::dvec4(0, 0, 3, 0),
                          glm::dvec4(0, 0, 0, 1));
  TransformMesh(mirror, sphere);
  ExpectClosedAndSmooth(sphere, 6 * volume, 1e-5);
  FlipOrientation(sphere);
  EXPECT_NEAR(Volume(sphere), -6 * volume, 1e-4);
}

// A tangent points to where u grows, and its sign says on which side of it v does, of a mesh that
// is turned over too.
TEST(Mesh, TransformKeepsTheSideOfTangents) {
  const glm::dmat4 stretch(glm::dvec4(2, 0, 0, 0), glm::dvec4(0.5, 1, 0, 0), glm::dvec4(0, 0, 3, 0),
                           glm::dvec4(4, 5, 6, 1));
  for (const double side : {1.0, -1.0}) {
    for (const bool flipped : {false, true}) {
      for (const float v : {1.0f, -1.0f}) {
        SCOPED_TRACE(testing::Message() << side << ' ' << flipped << ' ' << v);
        Mesh mesh;
        // u grows along x, and v along y or against it.
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, v, 0}};
        mesh.normals.assign(3, {0, 0, 1});
        mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
        mesh.tangents.assign(3, {1, 0, 0, v});
        mesh.triangles = {v > 0 ? glm::uvec3(0, 1, 2) : glm::uvec3(0, 2, 1)};
        TransformMesh(glm::dmat4(glm::dmat3(side)) * stretch, mesh);
        if (flipped) FlipOrientation(mesh);
        const glm::vec3 along_u = mesh.positions[1] - mesh.positions[0],
                        along_v = mesh.positions[2] - mesh.positions[0];
        for (std::size_t i = 0; i < 3; ++i) {
          const glm::vec3 tangent(mesh.tangents[i]);
          EXPECT_NEAR(glm::dot(glm::normalize(tangent), glm::normalize(along_u)), 1, 1e-6);
          EXPECT_GT(mesh.tangents[i].w * glm::dot(glm::cross(mesh.normals[i], tangent), along_v),
                    0);
        }
      }
    }
  }
}

Mesh Tetrahedron() {
  Mesh cage;
  cage.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  cage.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  return cage;
}

Mesh Subdivided(const Mesh& cage, int levels) {
  return LoopSubdivide(cage.positions, cage.triangles, levels);
}

// Returns an open, irregular fan: a corner of two edges, with valences 2 to 5 on the boundary and
// 3, 5 and 6 inside.
Mesh OpenPatch() {
  Mesh cage;
  for (int j = 0; j <= 3; ++j) {
    for (int i = 0; i <= 3; ++i) cage.positions.emplace_back(i, j, 0.3f * std::sin(2.0f * i + j));
  }
  for (std::uint32_t j = 0; j < 3; ++j) {
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t a = 4 * j + i, b = a + 1, c = a + 5, d = a + 4;
      if ((i + j) % 2 == 0) {
        cage.triangles.insert(cage.triangles.end(), {{a, b, c}, {a, c, d}});
      } else {
        cage.triangles.insert(cage.triangles.end(), {{a, b, d}, {b, c, d}});
      }
    }
  }
  return cage;
}

TEST(LoopSubdivision, CountsAndClosedSurface) {
  for (int levels = 0; levels <= 4; ++levels) {
    const Mesh mesh = Subdivided(Tetrahedron(), levels);
    const std::size_t faces = std::size_t{4} << (2 * levels);
    EXPECT_EQ(mesh.triangles.size(), faces);
    EXPECT_EQ(mesh.positions.size(), faces / 2 + 2);  // Euler: V = F / 2 + 2
    const EdgeCounts edges = CountEdges(mesh);
    EXPECT_EQ(edges.single + edges.wrong, 0);
    EXPECT_GT(Volume(mesh), 0);
  }
  const Mesh fine = Subdivided(Tetrahedron(), 5);
  ExpectClosedAndSmooth(fine, Volume(fine), 1e-12);
}

// The limit surface does not depend on the level at which subdivision stops: the cage's vertices
// keep their limit position and normal at every level. Wrong limit masks fail here.
TEST(LoopSubdivision, LimitsDoNotDependOnTheLevel) {
  const Mesh icosphere = Sphere(1, 1);
  for (const Mesh& cage : {Tetrahedron(), OpenPatch(), icosphere}) {
    const Mesh coarse = Subdivided(cage, 0);
    for (int levels = 1; levels <= 4; ++levels) {
      const Mesh fine = Subdivided(cage, levels);
      for (std::size_t v = 0; v < cage.positions.size(); ++v) {
        EXPECT_NEAR(glm::distance(coarse.positions[v], fine.positions[v]), 0, 1e-5) << v;
        EXPECT_NEAR(glm::dot(coarse.normals[v], fine.normals[v]), 1, 1e-5) << levels << " " << v;
      }
    }
  }
}

// The triangles of a fine mesh must converge to the normals from the masks, on boundaries too.
TEST(LoopSubdivision, NormalsAreThoseOfTheSurface) {
  for (const Mesh& cage : {Tetrahedron(), OpenPatch()}) {
    double previous = 1;
    for (const int levels : {4, 6}) {
      const Mesh mesh = Subdivided(cage, levels);
      const std::vector<glm::vec3> expected = AreaWeightedNormals(mesh.positions, mesh.triangles);
      double worst = 0;
      for (std::size_t v = 0; v < mesh.normals.size(); ++v) {
        worst = std::max<double>(worst, glm::distance(mesh.normals[v], expected[v]));
      }
      EXPECT_LT(worst, 0.6 * previous);
      previous = worst;
    }
    EXPECT_LT(previous, 0.05);
  }
}

TEST(LoopSubdivision, BoundaryIsItsOwnCurve) {
  // Moving inner vertices does not move the boundary.
  Mesh cage = OpenPatch();
  const Mesh before = Subdivided(cage, 3);
  for (const int inner : {5, 6, 9, 10}) cage.positions[inner].z += 1;
  const Mesh after = Subdivided(cage, 3);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const glm::uvec3& t : before.triangles) {
    for (int i = 0; i < 3; ++i) ++uses[std::minmax(t[i], t[(i + 1) % 3])];
  }
  int on_boundary = 0;
  for (const auto& [edge, count] : uses) {
    if (count != 1) continue;
    ++on_boundary;
    EXPECT_EQ(before.positions[edge.first], after.positions[edge.first]);
  }
  EXPECT_EQ(on_boundary, 12 * 8);
  EXPECT_NE(before.positions[5], after.positions[5]);
}

TEST(LoopSubdivision, FlatStaysFlatAndDegenerateCagesAreHandled) {
  Mesh flat = OpenPatch();
  for (glm::vec3& p : flat.positions) p.z = 0;
  for (const glm::vec3& n : Subdivided(flat, 2).normals) EXPECT_NEAR(n.z, 1, 1e-6);

  // The cage has three triangles on an edge, two fans on a vertex, a doubled and a degenerate
  // triangle, opposite windings and a vertex without triangle; positions must be finite and normals
  // of unit length all the same.
  const std::vector<glm::vec3> points = {{0, 0, 0},  {1, 0, 0},  {0, 1, 0}, {0, 0, 1},
                                         {-1, 0, 0}, {0, -1, 0}, {5, 5, 5}, {1, 1, 0}};
  const std::vector<std::vector<glm::uvec3>> cages = {{{0, 1, 2}, {0, 1, 3}, {0, 1, 5}},
                                                      {{0, 1, 2}, {0, 4, 5}},
                                                      {{0, 1, 2}, {0, 1, 2}},
                                                      {{0, 1, 2}, {0, 2, 1}},
                                                      {{0, 1, 1}, {0, 1, 2}, {3, 3, 3}},
                                                      {{0, 1, 2}, {1, 2, 7}},
                                                      {{0, 1, 2}, {0, 2, 4}, {0, 4, 5}, {0, 1, 5}},
                                                      {}};
  for (const auto& triangles : cages) {
    const Mesh mesh = LoopSubdivide(points, triangles, 2);
    EXPECT_EQ(FirstNonFinite(mesh.positions), mesh.positions.size());
    for (const glm::vec3& n : mesh.normals) EXPECT_NEAR(glm::length(n), 1, 1e-5);
  }
  EXPECT_EQ(LoopSubdivide(points, cages[0], 2).positions[6], glm::vec3(5, 5, 5));
}

// A fan of a hundred thousand triangles surrounds one vertex. Work that is quadratic in its valence
// would be 10^10 steps, and not end within the time that a test has.
TEST(LoopSubdivision, HugeValenceHasItsLimit) {
  constexpr std::uint32_t kCount = 100000;
  std::vector<glm::vec3> points = {{0, 0, 1}};
  std::vector<glm::uvec3> triangles;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double angle = glm::two_pi<double>() * i / kCount;
    points.emplace_back(std::cos(angle), std::sin(angle), 0);
    triangles.emplace_back(0, i + 1, (i + 1) % kCount + 1);
  }
  for (const int levels : {0, 1}) {
    SCOPED_TRACE(levels);
    const Mesh mesh = LoopSubdivide(points, triangles, levels);
    EXPECT_EQ(mesh.triangles.size(), (levels == 0 ? 1u : 4u) * kCount);
    // By Warren's weights, 3 / (8 n) of each of n neighbours, these count as much in the limit as
    // the vertex: 1 / (n + 3 / (8 beta)) is 1 / (2 n).
    EXPECT_NEAR(glm::distance(mesh.positions[0], glm::vec3(0, 0, 0.5f)), 0, 1e-5);
    EXPECT_NEAR(glm::distance(mesh.normals[0], glm::vec3(0, 0, 1)), 0, 1e-4);
    // The rim is a B-spline of so many points of a circle that it is the circle.
    for (std::uint32_t i = 1; i <= kCount; i += 997) {
      ASSERT_NEAR(glm::distance(mesh.positions[i], points[i]), 0, 1e-5) << i;
    }
  }
}

// A plane that rises by a half along x; a wrong sign of the height would let it fall.
TEST(Shapes, DisplacementTiltsNormals) {
  Mesh plane = Quad(1);
  Displace(plane, [](const glm::vec3& p) { return 0.5f * p.x; });
  for (std::size_t i = 0; i < plane.positions.size(); ++i) {
    EXPECT_FLOAT_EQ(plane.positions[i].y, 0.5f * plane.positions[i].x);
    EXPECT_LT(glm::distance(plane.normals[i], glm::normalize(glm::vec3(-0.5f, 1, 0))), 1e-6f);
  }
}

}  // namespace
}  // namespace skywave
