#include "scene/shapes/mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "image/srgb.h"

namespace skywave {
namespace {

glm::dvec3 AreaNormal(const std::vector<glm::vec3>& positions, const glm::uvec3& triangle) {
  // Doubles are needed because the squared lengths of tiny meshes would underflow in float.
  const glm::dvec3 p0 = positions[triangle.x];
  return glm::cross(glm::dvec3(positions[triangle.y]) - p0, glm::dvec3(positions[triangle.z]) - p0);
}

}  // namespace

void TransformMesh(const glm::dmat4& to, Mesh& mesh) {
  const glm::dmat3 linear(to);
  for (glm::vec3& p : mesh.positions) p = linear * glm::dvec3(p) + glm::dvec3(to[3]);
  if (!mesh.normals.empty()) {
    const glm::dmat3 normal_matrix = glm::transpose(glm::inverse(linear));
    for (glm::vec3& n : mesh.normals) n = glm::normalize(normal_matrix * glm::dvec3(n));
  }
  const bool mirrors = glm::determinant(linear) < 0;
  for (glm::vec4& t : mesh.tangents) {
    t = glm::vec4(glm::dvec4(linear * glm::dvec3(t), mirrors ? -t.w : t.w));
  }
  if (mirrors) {
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  }
}

void FlipOrientation(Mesh& mesh) {
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  for (glm::vec3& n : mesh.normals) n = -n;
  for (glm::vec4& t : mesh.tangents) t.w = -t.w;
}

void GiveCornersUvs(Mesh& mesh) {
  Mesh corners;
  for (glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      corners.positions.push_back(mesh.positions[t[i]]);
      if (!mesh.normals.empty()) corners.normals.push_back(mesh.normals[t[i]]);
      corners.uvs.emplace_back(i > 0, i > 1);
      t[i] = std::uint32_t(corners.positions.size() - 1);
    }
  }
  mesh.positions = std::move(corners.positions);
  mesh.normals = std::move(corners.normals);
  mesh.uvs = std::move(corners.uvs);
}

void AlignWindingWithNormals(Mesh& mesh) {
  if (mesh.normals.empty()) return;
  for (glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 shading = glm::dvec3(mesh.normals[t.x]) + glm::dvec3(mesh.normals[t.y]) +
                               glm::dvec3(mesh.normals[t.z]);
    if (glm::dot(AreaNormal(mesh.positions, t), shading) < 0) std::swap(t.y, t.z);
  }
}

std::vector<glm::vec3> AreaWeightedNormals(const std::vector<glm::vec3>& positions,
                                           const std::vector<glm::uvec3>& triangles) {
  std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0));
  for (const glm::uvec3& t : triangles) {
    const glm::dvec3 normal = AreaNormal(positions, t);
    for (int corner = 0; corner < 3; ++corner) sums[t[corner]] += normal;
  }
  std::vector<glm::vec3> normals(positions.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double length = glm::length(sums[i]);
    normals[i] = length > 0 ? glm::vec3(sums[i] / length) : glm::vec3(0, 0, 1);
  }
  return normals;
}

void NormalizeNormals(Mesh& mesh) {
  std::vector<glm::vec3> fallback;
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    const glm::dvec3 n = mesh.normals[i];
    const double length = glm::length(n);
    if (length > 0) {
      mesh.normals[i] = n / length;
    } else {
      if (fallback.empty()) fallback = AreaWeightedNormals(mesh.positions, mesh.triangles);
      mesh.normals[i] = fallback[i];
    }
  }
}

glm::vec3 ColorOfSrgb(const glm::vec3& encoded) {
  glm::vec3 color;
  for (int c = 0; c < 3; ++c) {
    const double share = encoded[c] > 0 ? std::min(double(encoded[c]), 1.0) : 0;
    color[c] = float(LinearFromSrgb(share));
  }
  return color;
}

std::size_t FirstNonFinite(const std::vector<glm::vec3>& positions) {
  std::size_t i = 0;
  while (i < positions.size() && std::isfinite(positions[i].x) && std::isfinite(positions[i].y) &&
         std::isfinite(positions[i].z)) {
    ++i;
  }
  return i;
}

}  // namespace skywave
