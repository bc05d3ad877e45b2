#include "scene/shapes/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "base/error.h"
#include "scene/shapes/shapes.h"

namespace skywave {
namespace {

constexpr std::uint32_t kSides = 8;  // of a tube
constexpr std::size_t kTubeTriangles = 2 * kSides;

// Returns the vertices that get a sphere, each once, in ascending order.
std::vector<std::uint32_t> Centres(const PointsAndLines& parts) {
  std::vector<std::uint32_t> centres = parts.points;
  for (const glm::uvec2& line : parts.lines) centres.insert(centres.end(), {line.x, line.y});
  std::sort(centres.begin(), centres.end());
  centres.erase(std::unique(centres.begin(), centres.end()), centres.end());
  return centres;
}

// Appends a vertex with all that vertex `from` of `vertices` has but its place.
void AppendVertex(const Mesh& vertices, std::uint32_t from, const glm::vec3& position,
                  const glm::vec3& normal, Mesh& mesh) {
  mesh.positions.push_back(position);
  mesh.normals.push_back(normal);
  if (!vertices.uvs.empty()) mesh.uvs.push_back(vertices.uvs[from]);
  if (!vertices.second_uvs.empty()) mesh.second_uvs.push_back(vertices.second_uvs[from]);
  if (!vertices.colors.empty()) mesh.colors.push_back(vertices.colors[from]);
  if (!vertices.alphas.empty()) mesh.alphas.push_back(vertices.alphas[from]);
}

void AppendSphere(const Mesh& vertices, std::uint32_t centre, const Mesh& unit, float radius,
                  Mesh& mesh) {
  const auto first = std::uint32_t(mesh.positions.size());
  for (const glm::vec3& normal : unit.positions) {
    AppendVertex(vertices, centre, vertices.positions[centre] + radius * normal, normal, mesh);
  }
  for (const glm::uvec3& triangle : unit.triangles) mesh.triangles.push_back(first + triangle);
}

// The spheres at both ends close the tube.
void AppendTube(const Mesh& vertices, const glm::uvec2& line, float radius, Mesh& mesh) {
  const glm::vec3 ends[] = {vertices.positions[line.x], vertices.positions[line.y]};
  const glm::vec3 along = ends[1] - ends[0];
  const float length = glm::length(along);
  if (!(length > 0) || !std::isfinite(length)) return;
  const glm::vec3 axis = along / length;
  const glm::vec3 aside = std::abs(axis.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 x = glm::normalize(glm::cross(axis, aside)), y = glm::cross(axis, x);
  const auto first = std::uint32_t(mesh.positions.size());
  for (std::uint32_t side = 0; side < kSides; ++side) {
    const float angle = 2 * std::numbers::pi_v<float> * float(side) / float(kSides);
    const glm::vec3 normal = std::cos(angle) * x + std::sin(angle) * y;
    for (int end = 0; end < 2; ++end) {
      AppendVertex(vertices, line[end], ends[end] + radius * normal, normal, mesh);
    }
    const std::uint32_t here = first + 2 * side, next = first + 2 * ((side + 1) % kSides);
    mesh.triangles.emplace_back(here, next, next + 1);
    mesh.triangles.emplace_back(here, next + 1, here + 1);
  }
}

}  // namespace

PointsAndLines AllPoints(const Mesh& vertices) {
  PointsAndLines parts;
  parts.points.resize(vertices.positions.size());
  std::iota(parts.points.begin(), parts.points.end(), 0u);
  return parts;
}

PointTessellation TessellationOf(const PointsAndLines& parts) {
  constexpr double kTriangles = 2e6;
  constexpr int kFinest = 8;  // an edge spans 8 degrees
  const std::size_t spheres = Centres(parts).size();
  PointTessellation found;
  if (spheres > 0) {
    found.frequency = std::clamp(int(std::sqrt(kTriangles / (20 * double(spheres)))), 1, kFinest);
  }
  found.triangles = spheres * 20 * std::size_t(found.frequency) * std::size_t(found.frequency) +
                    parts.lines.size() * kTubeTriangles;
  return found;
}

Mesh MakePoints(const Mesh& vertices, const PointsAndLines& parts, float diameter,
                std::size_t max_triangles, const std::string& path) {
  const PointTessellation tessellation = TessellationOf(parts);
  if (tessellation.triangles > max_triangles) {
    throw InputError(InputPosition::File(path),
                     fmt::format("its points and lines have {} triangles, more than {} "
                                 "(`max-triangles`)",
                                 tessellation.triangles, max_triangles));
  }
  Mesh mesh;
  mesh.name = vertices.name;
  mesh.material = vertices.material;
  mesh.triangles.reserve(tessellation.triangles);
  const Mesh unit = Sphere(1, tessellation.frequency);
  for (const std::uint32_t centre : Centres(parts)) {
    AppendSphere(vertices, centre, unit, 0.5f * diameter, mesh);
  }
  for (const glm::uvec2& line : parts.lines) AppendTube(vertices, line, 0.5f * diameter, mesh);
  return mesh;
}

float PointSizeFor(const std::vector<glm::vec3>& positions) {
  constexpr std::size_t kSample = 32;
  constexpr float kUnknown = 0.01f;
  const std::size_t count = positions.size(), step = std::max<std::size_t>(count / kSample, 1);
  if (count < 2) return kUnknown;
  std::vector<float> nearest;
  for (std::size_t i = 0; i < count; i += step) {
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t k = 0; k < count; ++k) {
      if (k != i) least = std::min(least, glm::length(positions[k] - positions[i]));
    }
    nearest.push_back(least);
  }
  const auto middle = nearest.begin() + std::ptrdiff_t(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  if (!(*middle > 0) || !std::isfinite(*middle)) return kUnknown;
  const float unit = std::pow(10.0f, std::floor(std::log10(*middle)));
  return std::round(*middle / unit) * unit;
}

}  // namespace skywave
