// Tests points and lines: where their spheres and tubes stand, and which ones readers make.
#include "scene/shapes/points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "scene/reader.h"
#include "tests/support/gltf_document.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr float kDiameter = 0.25f;

// Returns the distance of a point to a segment.
float DistanceTo(const glm::vec3& point, const glm::vec3& from, const glm::vec3& to) {
  const glm::vec3 along = to - from;
  const float length2 = glm::dot(along, along);
  const float t = length2 > 0 ? std::clamp(glm::dot(point - from, along) / length2, 0.f, 1.f) : 0;
  return glm::length(point - (from + t * along));
}

// Returns the volume that a closed mesh encloses, which is negative if it is wound inwards.
double Volume(const Mesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    sum += glm::dot(a, glm::cross(b, c)) / 6;
  }
  return sum;
}

TEST(Points, AreSpheresWithTheirColors) {
  Mesh vertices;
  vertices.positions = {{1, 2, 3}, {9, 9, 9}, {-4, 0, 0}};
  vertices.colors = {glm::vec3(0.25f), glm::vec3(0.5f), glm::vec3(1)};
  vertices.alphas = {0.125f, 0.5f, 1};
  vertices.name = "cloud";
  vertices.material = 3;
  const PointsAndLines parts = {.points = {2, 0, 0}, .lines = {}};
  const Mesh mesh = MakePoints(vertices, parts, kDiameter, 1 << 20, "t");
  EXPECT_EQ(mesh.name, "cloud");
  EXPECT_EQ(mesh.material, 3u);
  EXPECT_EQ(mesh.triangles.size(), TessellationOf(parts).triangles);
  EXPECT_EQ(mesh.triangles.size(), 2u * 20 * 64) << "a point that is named twice is one sphere";
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const int from = mesh.colors[i].x == 0.25f ? 0 : 2;
    const glm::vec3 offset = mesh.positions[i] - vertices.positions[std::size_t(from)];
    ASSERT_NEAR(glm::length(offset), kDiameter / 2, 1e-6);
    ASSERT_NEAR(glm::length(glm::normalize(offset) - mesh.normals[i]), 0, 1e-5);
    ASSERT_EQ(mesh.alphas[i], vertices.alphas[std::size_t(from)]);
  }
  const double ball = 4 / 3. * 3.14159265 * std::pow(kDiameter / 2, 3);
  EXPECT_NEAR(Volume(mesh) / (2 * ball), 1, 0.03);
}

TEST(Points, OfLinesAreTubesWithRoundEnds) {
  Mesh vertices;
  vertices.positions = {{0, 0, 0}, {0, 3, 0}, {2, 3, 1}, {2, 3, 1}};
  const PointsAndLines parts = {.points = {}, .lines = {{0, 1}, {1, 2}, {2, 3}}};
  const Mesh mesh = MakePoints(vertices, parts, kDiameter, 1 << 20, "t");
  double least = 1;
  for (const glm::vec3& p : mesh.positions) {
    const float distance = std::min(DistanceTo(p, vertices.positions[0], vertices.positions[1]),
                                    DistanceTo(p, vertices.positions[1], vertices.positions[2]));
    ASSERT_LE(distance, kDiameter / 2 + 1e-6);
    least = std::min(least, double(distance));
  }
  EXPECT_LT(least, kDiameter / 4) << "spheres close the ends inside of the next tube";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    const glm::vec3 normal = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
    ASSERT_GT(glm::dot(glm::cross(b - a, c - a), normal), 0) << i << " is wound inwards";
  }
}

TEST(Points, AreCoarserTheMoreThereAre) {
  const auto frequency = [](std::uint32_t count) {
    PointsAndLines parts;
    for (std::uint32_t i = 0; i < count; ++i) parts.points.push_back(i);
    const PointTessellation found = TessellationOf(parts);
    EXPECT_EQ(found.triangles, std::size_t(count) * 20 * found.frequency * found.frequency);
    return found.frequency;
  };
  EXPECT_EQ(frequency(1), 8);
  EXPECT_EQ(frequency(6250), 4);
  EXPECT_EQ(frequency(100000), 1);
  EXPECT_EQ(frequency(1000000), 1);
}

TEST(Points, AdvisedSizeIsTheirSpacing) {
  std::vector<glm::vec3> grid;
  for (int i = 0; i < 1000; ++i) grid.push_back(0.0312f * glm::vec3(i % 10, i / 10 % 10, i / 100));
  EXPECT_FLOAT_EQ(PointSizeFor(grid), 0.03f);
  EXPECT_FLOAT_EQ(PointSizeFor({}), 0.01f);
  EXPECT_FLOAT_EQ(PointSizeFor({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), 0.01f);
}

class PointFiles : public testing::Test {
 protected:
  // Returns the scene of a file, with points of kDiameter.
  Scene Read(const std::string& name, const std::string& text) const {
    ReadOptions options;
    options.point_size = kDiameter;
    return ReadScene(folder_.Write(name, text), options);
  }
  // Expects the points and lines of `parts` at the three places of all these files.
  static void ExpectParts(const Mesh& mesh, const PointsAndLines& parts) {
    Mesh vertices;
    vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const Mesh expected = MakePoints(vertices, parts, kDiameter, 1 << 20, "t");
    EXPECT_EQ(mesh.positions, expected.positions);
    EXPECT_EQ(mesh.triangles, expected.triangles);
  }
  std::string Error(const std::string& name, const std::string& text, ReadOptions options) const {
    try {
      ReadScene(folder_.Write(name, text), options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(PointFiles, OfPlyMayHaveVerticesAlone) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string data = "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n";
  const std::string none = "element face 0\nproperty list uchar int vertex_indices\n";
  for (const std::string& faces : {std::string(), none}) {
    const std::string text = header + faces + "end_header\n" + data;
    const Scene scene = Read("t.ply", text);
    ASSERT_EQ(scene.meshes.size(), 1u);
    ExpectParts(scene.meshes[0], {.points = {0, 1, 2}, .lines = {}});
    EXPECT_EQ(scene.meshes[0].colors.front(), glm::vec3(1, 0, 0));
    EXPECT_EQ(scene.meshes[0].colors.back(), glm::vec3(0, 0, 1));
    EXPECT_EQ(scene.materials[0].reflectance, glm::vec3(1));
    EXPECT_NE(Error("t.ply", text, {}).find("has 3 vertices and no faces: `point-size 1` shows"),
              std::string::npos);
    ReadOptions few;
    few.point_size = kDiameter, few.max_triangles = 100;
    EXPECT_NE(Error("t.ply", text, few).find("3840 triangles, more than 100 (`max-triangles`)"),
              std::string::npos);
  }
}

TEST_F(PointFiles, OfObjHavePointsLinesOrVerticesAlone) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", face = "f 1 2 3\n";
  const PointsAndLines lines = {.points = {}, .lines = {{0, 1}, {1, 2}, {2, 0}}};
  Scene scene = Read("t.obj", vertices + face + "l 1/1 -2 -1//1\nl 3 1\n");
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
  ExpectParts(scene.meshes[1], lines);
  scene = Read("t.obj", vertices + "p 3\np 1 -3\n");
  ASSERT_EQ(scene.meshes.size(), 1u);
  ExpectParts(scene.meshes[0], {.points = {0, 2}, .lines = {}});
  scene = Read("t.obj", vertices);
  ASSERT_EQ(scene.meshes.size(), 1u);
  ExpectParts(scene.meshes[0], {.points = {0, 1, 2}, .lines = {}});

  scene = ReadScene(folder_.Write("t.obj", vertices), {});
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("vertices without faces are left out: `point-size 1` shows"),
            std::string::npos)
      << scene.warnings[0];
  EXPECT_NE(Error("t.obj", vertices + "p one\n", {}).find("t.obj:4: 'one' is no index"),
            std::string::npos);
}

TEST_F(PointFiles, OfGltfHaveModes) {
  const auto at = [](int mode) {
    GltfDocument document = TriangleDocument();
    document.json["nodes"] = {{{"mesh", 0}}};
    document.json["scenes"] = {{{"nodes", {0}}}};
    document.json["meshes"][0]["primitives"][0]["mode"] = mode;
    return document.text();
  };
  const PointsAndLines expected[] = {{.points = {0, 1, 2}, .lines = {}},
                                     {.points = {}, .lines = {{0, 1}}},
                                     {.points = {}, .lines = {{0, 1}, {1, 2}, {2, 0}}},
                                     {.points = {}, .lines = {{0, 1}, {1, 2}}}};
  for (int mode = 0; mode < 4; ++mode) {
    const Scene scene = Read("t.gltf", at(mode));
    ASSERT_EQ(scene.meshes.size(), 1u) << mode;
    ExpectParts(scene.meshes[0], expected[mode]);
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    EXPECT_NE(Error("t.gltf", at(mode), {.strict = true}).find("`point-size` shows them"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace skywave
