#include "scene/shapes/smooth_normals.h"

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

// Corner c of triangle i has number 3 i + c. The corners at position p are corner[begin[p]] to
// corner[begin[p + 1] - 1].
struct CornersAtPositions {
  std::vector<std::uint32_t> begin, corner;
};

CornersAtPositions FindCorners(std::size_t positions, const std::vector<glm::uvec3>& triangles) {
  CornersAtPositions at;
  at.begin.assign(positions + 1, 0);
  at.corner.resize(3 * triangles.size());
  for (const glm::uvec3& t : triangles) {
    for (int c = 0; c < 3; ++c) ++at.begin[t[c] + 1];
  }
  for (std::size_t p = 0; p < positions; ++p) at.begin[p + 1] += at.begin[p];
  std::vector<std::uint32_t> next(at.begin.begin(), at.begin.end() - 1);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      at.corner[next[triangles[i][c]]++] = static_cast<std::uint32_t>(3 * i + c);
    }
  }
  return at;
}

// Computed in double because squares of small lengths would underflow.
glm::dvec3 UnitOrZero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? v / length : glm::dvec3(0);
}

struct Facets {
  std::vector<glm::dvec3> normal;  // unit normal per triangle; 0 without area
  std::vector<float> angle;        // angle per corner [rad]
};

Facets MeasureFacets(const std::vector<glm::vec3>& positions,
                     const std::vector<glm::uvec3>& triangles) {
  Facets facets;
  facets.normal.reserve(triangles.size());
  facets.angle.reserve(3 * triangles.size());
  for (const glm::uvec3& t : triangles) {
    const glm::dvec3 p[3] = {positions[t.x], positions[t.y], positions[t.z]};
    facets.normal.push_back(UnitOrZero(glm::cross(p[1] - p[0], p[2] - p[0])));
    for (int c = 0; c < 3; ++c) {
      const glm::dvec3 a = p[(c + 1) % 3] - p[c], b = p[(c + 2) % 3] - p[c];
      facets.angle.push_back(
          static_cast<float>(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b))));
    }
  }
  return facets;
}

}  // namespace

std::vector<glm::vec3> SmoothCornerNormals(const std::vector<glm::vec3>& positions,
                                           const std::vector<glm::uvec3>& triangles,
                                           std::span<const std::uint32_t> groups) {
  const Facets facets = MeasureFacets(positions, triangles);
  const double cosine = std::cos(glm::radians(double{kCreaseDegrees}));
  const auto smooth = [&](std::size_t i, std::size_t j) {
    if (!groups.empty()) return groups[i] != 0 && groups[i] == groups[j];
    return glm::dot(facets.normal[i], facets.normal[j]) >= cosine;
  };
  const CornersAtPositions at = FindCorners(positions.size(), triangles);
  std::vector<glm::vec3> normals(3 * triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t begin = at.begin[triangles[i][c]], end = at.begin[triangles[i][c] + 1];
      glm::dvec3 sum(0);
      for (std::uint32_t a = begin; a < end && end - begin <= kMaxSmoothValence; ++a) {
        const std::uint32_t other = at.corner[a];
        if (smooth(i, other / 3)) sum += double{facets.angle[other]} * facets.normal[other / 3];
      }
      if (sum == glm::dvec3(0)) sum = facets.normal[i];
      if (sum == glm::dvec3(0)) sum = glm::dvec3(0, 0, 1);
      normals[3 * i + c] = UnitOrZero(sum);
    }
  }
  return normals;
}

}  // namespace skywave
