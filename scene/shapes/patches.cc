#include "scene/shapes/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace skywave {
namespace {

int Steps(double degrees) { return std::max(1, int(std::ceil(std::abs(degrees) / kPatchDegrees))); }

constexpr int kCurvedRows = 45;  // of surfaces that are curved along v, too

// Returns (cos, sin) of a fraction of a turn; a whole turn ends exactly where it begins.
glm::dvec2 OnCircle(double u, double phi_degrees) {
  const double phi = glm::radians(u * phi_degrees);
  return u * phi_degrees == 360 ? glm::dvec2(1, 0) : glm::dvec2(std::cos(phi), std::sin(phi));
}

}  // namespace

void AddPatch(int columns, int rows, const PatchSurface& surface, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      const SurfacePoint point = surface(double(column) / columns, double(row) / rows);
      mesh.positions.emplace_back(point.position);
      mesh.normals.emplace_back(glm::normalize(point.normal));
      mesh.uvs.emplace_back(point.uv);
    }
  }
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const glm::vec3 &pa = mesh.positions[a], &pb = mesh.positions[b], &pc = mesh.positions[c];
    if (pa != pb && pb != pc && pc != pa) mesh.triangles.emplace_back(a, b, c);
  };
  const auto width = static_cast<std::uint32_t>(columns + 1);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::uint32_t corner = first + std::uint32_t(row) * width + std::uint32_t(column);
      add(corner, corner + 1, corner + width + 1);
      add(corner, corner + width + 1, corner + width);
    }
  }
}

Mesh SpherePatch(float radius, float low, float high, float phi_degrees) {
  const auto polar = [&](float z) { return std::acos(std::clamp(double(z) / radius, -1.0, 1.0)); };
  const double begin = polar(low), end = polar(high);
  Mesh mesh;
  AddPatch(
      Steps(phi_degrees), Steps(glm::degrees(begin - end)),
      [&](double u, double v) {
        const double theta = glm::mix(begin, end, v);
        // At the poles, where sin(theta) is zero up to rounding, the circle shrinks to a point.
        const double across = std::abs(std::sin(theta)) < 1e-12 ? 0 : std::sin(theta);
        const glm::dvec2 circle = OnCircle(u, phi_degrees);
        const glm::dvec3 normal(across * circle.x, across * circle.y, std::cos(theta));
        return SurfacePoint{double(radius) * normal, normal, {u, v}};
      },
      mesh);
  return mesh;
}

Mesh CylinderPatch(float radius, float low, float high, float phi_degrees) {
  Mesh mesh;
  AddPatch(
      Steps(phi_degrees), 1,
      [&](double u, double v) {
        const glm::dvec3 normal(OnCircle(u, phi_degrees), 0);
        const glm::dvec3 along(0, 0, glm::mix(double(low), double(high), v));
        return SurfacePoint{double(radius) * normal + along, normal, {u, v}};
      },
      mesh);
  return mesh;
}

Mesh ConePatch(float radius, float height, float phi_degrees) {
  Mesh mesh;
  AddPatch(
      Steps(phi_degrees), 1,
      [&](double u, double v) {
        const glm::dvec2 circle = OnCircle(u, phi_degrees);
        return SurfacePoint{{(1 - v) * double(radius) * circle, v * double(height)},
                            {double(height) * circle, radius},
                            {u, v}};
      },
      mesh);
  return mesh;
}

Mesh ParaboloidPatch(float radius, float low, float high, float phi_degrees) {
  // Rows are equally far apart in the distance from the axis, so the apex is as round as the rim.
  const double first = std::sqrt(double(low) / high);
  Mesh mesh;
  AddPatch(
      Steps(phi_degrees), kCurvedRows,
      [&](double u, double w) {
        const double s = glm::mix(first, 1.0, w), z = s * s * high;
        const glm::dvec2 circle = OnCircle(u, phi_degrees);
        return SurfacePoint{{s * double(radius) * circle, z},
                            {2.0 * s * double(high) * circle, -double(radius)},
                            {u, (z - low) / (double(high) - low)}};
      },
      mesh);
  return mesh;
}

Mesh HyperboloidPatch(const glm::dvec3& p1, const glm::dvec3& p2, float phi_degrees) {
  const glm::dvec3 line = p2 - p1;
  const auto turned = [](const glm::dvec3& p, const glm::dvec2& circle) {
    return glm::dvec3(p.x * circle.x - p.y * circle.y, p.x * circle.y + p.y * circle.x, p.z);
  };
  const bool straight = line.x * p1.y == line.y * p1.x;  // the line lies in a plane of the axis
  Mesh mesh;
  AddPatch(
      Steps(phi_degrees), straight ? 1 : kCurvedRows,
      [&](double u, double v) {
        const glm::dvec2 circle = OnCircle(u, phi_degrees);
        // A point of the axis takes its normal from beside it.
        glm::dvec3 beside = p1 + v * line;
        if (beside.x == 0 && beside.y == 0) beside = p1 + (v < 0.5 ? 1e-6 : 1 - 1e-6) * line;
        const glm::dvec3 across = turned({-beside.y, beside.x, 0}, circle);
        glm::dvec3 normal = glm::cross(across, turned(line, circle));
        if (normal == glm::dvec3(0)) normal = {0, 0, 1};
        return SurfacePoint{turned(p1 + v * line, circle), normal, {u, v}};
      },
      mesh);
  return mesh;
}

Mesh DiskPatch(float radius, float inner_radius, float height, float phi_degrees) {
  Mesh mesh;
  AddPatch(
      Steps(phi_degrees), 1,
      [&](double u, double v) {
        const double r = glm::mix(double(radius), double(inner_radius), v);
        return SurfacePoint{{r * OnCircle(u, phi_degrees), height}, {0, 0, 1}, {u, v}};
      },
      mesh);
  return mesh;
}

void AddBilinearPatch(const BilinearCorners& corners, const glm::uvec4& patch, Mesh& mesh) {
  std::array<SurfacePoint, 4> c;
  for (int i = 0; i < 4; ++i) {
    const std::uint32_t vertex = patch[i];
    c[std::size_t(i)] = {
        corners.positions[vertex],
        corners.normals.empty() ? glm::dvec3(0) : glm::dvec3(corners.normals[vertex]),
        corners.uvs.empty() ? glm::dvec2(i % 2, i / 2) : glm::dvec2(corners.uvs[vertex])};
  }
  const auto blend = [&](auto SurfacePoint::*what, double u, double v) {
    return (1 - v) * ((1 - u) * (c[0].*what) + u * (c[1].*what)) +
           v * ((1 - u) * (c[2].*what) + u * (c[3].*what));
  };
  // This is the only nonlinear term; rounding must not count as curvature.
  const auto bend = [&](auto SurfacePoint::*what) {
    const auto twist = (c[0].*what) - (c[1].*what) - (c[2].*what) + (c[3].*what);
    return glm::length(twist) > 1e-6 * (glm::length((c[1].*what) - (c[0].*what)) +
                                        glm::length((c[2].*what) - (c[0].*what)));
  };
  const int steps = bend(&SurfacePoint::position) || bend(&SurfacePoint::uv) ? kBilinearSteps : 1;
  AddPatch(
      steps, steps,
      [&](double u, double v) {
        const auto along = [&](int from, int to) {
          return c[std::size_t(to)].position - c[std::size_t(from)].position;
        };
        glm::dvec3 normal = blend(&SurfacePoint::normal, u, v);
        if (normal == glm::dvec3(0)) {
          normal = glm::cross(glm::mix(along(0, 1), along(2, 3), v),
                              glm::mix(along(0, 2), along(1, 3), u));
        }
        // The patch has no extent here; its triangles have no area either.
        if (normal == glm::dvec3(0)) normal = {0, 0, 1};
        return SurfacePoint{blend(&SurfacePoint::position, u, v), normal,
                            blend(&SurfacePoint::uv, u, v)};
      },
      mesh);
}

}  // namespace skywave
