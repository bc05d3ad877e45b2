#include "scene/shapes/shapes.h"

#include <cmath>
#include <cstdint>
#include <glm/gtc/constants.hpp>
#include <map>
#include <utility>

#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

// Adds the quad a b c d (in this winding) as two triangles; those with a repeated corner are left
// out.
void AddQuad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, Mesh& mesh) {
  if (a != b && b != c && c != a) mesh.triangles.emplace_back(a, b, c);
  if (a != c && c != d && d != a) mesh.triangles.emplace_back(a, c, d);
}

struct Icosahedron {
  std::vector<glm::dvec3> corners;
  std::vector<glm::uvec3> faces;
};

Icosahedron MakeIcosahedron() {
  const double g = (1 + std::sqrt(5.0)) / 2;  // the corners are the cyclic permutations of (0, 1,
                                              // g)
  Icosahedron solid;
  for (int axis = 0; axis < 3; ++axis) {
    for (int signs = 0; signs < 4; ++signs) {
      glm::dvec3 corner(0);
      corner[(axis + 1) % 3] = signs & 1 ? -1 : 1;
      corner[(axis + 2) % 3] = signs & 2 ? -g : g;
      solid.corners.push_back(corner);
    }
  }
  // The faces are the triples at mutual distance 2, wound outwards.
  const auto adjacent = [&](std::uint32_t a, std::uint32_t b) {
    return glm::distance(solid.corners[a], solid.corners[b]) < 2.1;
  };
  for (std::uint32_t a = 0; a < 12; ++a) {
    for (std::uint32_t b = a + 1; b < 12; ++b) {
      for (std::uint32_t c = b + 1; c < 12; ++c) {
        if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(c, a)) continue;
        const glm::dvec3 pa = solid.corners[a], pb = solid.corners[b], pc = solid.corners[c];
        const bool outwards = glm::dot(glm::cross(pb - pa, pc - pa), pa) > 0;
        solid.faces.push_back(outwards ? glm::uvec3(a, b, c) : glm::uvec3(a, c, b));
      }
    }
  }
  return solid;
}

}  // namespace

Mesh Sphere(float radius, int frequency) {
  const Icosahedron solid = MakeIcosahedron();
  const auto n = static_cast<std::uint32_t>(frequency);
  Mesh mesh;
  // A grid point on an edge is identified by its weights at the corners, so that faces share it.
  using Weights = std::map<std::uint32_t, std::uint32_t>;
  std::map<Weights, std::uint32_t> shared;
  for (const glm::uvec3& face : solid.faces) {
    const auto vertex = [&](std::uint32_t i, std::uint32_t j) {
      const std::uint32_t weights[] = {n - i - j, i, j};
      const auto add = [&] {
        glm::dvec3 point(0);
        for (int corner = 0; corner < 3; ++corner) {
          point += static_cast<double>(weights[corner]) * solid.corners[face[corner]];
        }
        const glm::dvec3 normal = glm::normalize(point);
        mesh.normals.emplace_back(normal);
        mesh.positions.emplace_back(static_cast<double>(radius) * normal);
        return static_cast<std::uint32_t>(mesh.positions.size() - 1);
      };
      if (weights[0] > 0 && weights[1] > 0 && weights[2] > 0) return add();
      Weights key;
      for (int corner = 0; corner < 3; ++corner) {
        if (weights[corner] > 0) key[face[corner]] = weights[corner];
      }
      const auto found = shared.find(key);
      return found != shared.end() ? found->second : shared[key] = add();
    };
    std::vector<std::uint32_t> row, next_row;
    for (std::uint32_t j = 0; j <= n; ++j) row.push_back(vertex(0, j));
    for (std::uint32_t i = 0; i < n; ++i) {
      next_row.clear();
      for (std::uint32_t j = 0; j < n - i; ++j) next_row.push_back(vertex(i + 1, j));
      for (std::uint32_t j = 0; j < n - i; ++j) {
        mesh.triangles.emplace_back(row[j], next_row[j], row[j + 1]);
        if (j + 1 < n - i) mesh.triangles.emplace_back(row[j + 1], next_row[j], next_row[j + 1]);
      }
      std::swap(row, next_row);
    }
  }
  return mesh;
}

Mesh Quad(float half_size) {
  const float h = half_size;
  Mesh mesh;
  mesh.positions = {{-h, 0, h}, {h, 0, h}, {h, 0, -h}, {-h, 0, -h}};
  mesh.normals.assign(4, glm::vec3(0, 1, 0));
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Mesh RoundedBox(const glm::vec3& half_size, float radius, int segments) {
  // A lat-long sphere is cut open along the three coordinate planes and its octants are moved apart
  // to the corners of the inner box: the cuts become the flat faces and the cylindrical edges.
  const glm::dvec3 inner = glm::dvec3(half_size) - static_cast<double>(radius);
  const auto s = static_cast<std::uint32_t>(segments);
  const std::uint32_t columns = 4 * (s + 1), rows = 2 * (s + 1);
  Mesh mesh;
  const auto add = [&](std::uint32_t row, std::uint32_t column) {
    const std::uint32_t half = row / (s + 1), quadrant = column / (s + 1);
    const double theta = glm::half_pi<double>() * (half + double(row % (s + 1)) / s);
    const double phi = glm::half_pi<double>() * (quadrant + double(column % (s + 1)) / s);
    const glm::dvec3 normal(std::sin(theta) * std::cos(phi), std::cos(theta),
                            -std::sin(theta) * std::sin(phi));
    const glm::dvec3 octant(quadrant == 0 || quadrant == 3 ? 1 : -1, half == 0 ? 1 : -1,
                            quadrant < 2 ? -1 : 1);
    mesh.normals.emplace_back(normal);
    mesh.positions.emplace_back(octant * inner + static_cast<double>(radius) * normal);
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  };
  std::vector<std::uint32_t> above, row_vertices(columns);
  for (std::uint32_t row = 0; row < rows; ++row) {
    const bool pole = row == 0 || row + 1 == rows;  // one vertex per quadrant
    for (std::uint32_t column = 0; column < columns; ++column) {
      const bool repeated = pole && column % (s + 1) != 0;
      row_vertices[column] = repeated ? row_vertices[column - 1] : add(row, column);
    }
    for (std::uint32_t column = 0; row > 0 && column < columns; ++column) {
      const std::uint32_t right = (column + 1) % columns;
      AddQuad(above[column], row_vertices[column], row_vertices[right], above[right], mesh);
    }
    if (pole) {
      const std::uint32_t a = row_vertices[0], b = row_vertices[s + 1],
                          c = row_vertices[2 * (s + 1)], d = row_vertices[3 * (s + 1)];
      row == 0 ? AddQuad(a, b, c, d, mesh) : AddQuad(d, c, b, a, mesh);
    }
    above = row_vertices;
  }
  return mesh;
}

Mesh Revolve(std::span<const glm::vec2> profile, int segments) {
  const auto columns = static_cast<std::uint32_t>(segments);
  Mesh mesh;
  std::vector<std::uint32_t> below, row(columns);
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const glm::dvec2 along = glm::dvec2(profile[std::min(i + 1, profile.size() - 1)]) -
                             glm::dvec2(profile[i == 0 ? 0 : i - 1]);
    const bool on_axis = profile[i].x == 0;
    // On the axis, a smooth surface is level.
    glm::dvec2 outside = on_axis ? glm::dvec2(0, along.x > 0 ? -1 : 1)
                                 : glm::normalize(glm::dvec2(along.y, -along.x));
    for (std::uint32_t column = 0; column < columns; ++column) {
      if (on_axis && column > 0) {
        row[column] = row[0];
        continue;
      }
      const double phi = glm::two_pi<double>() * column / columns;
      const glm::dvec3 radial(std::cos(phi), 0, -std::sin(phi));
      row[column] = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.normals.emplace_back(outside.x * radial + glm::dvec3(0, outside.y, 0));
      mesh.positions.emplace_back(static_cast<double>(profile[i].x) * radial +
                                  glm::dvec3(0, profile[i].y, 0));
    }
    for (std::uint32_t column = 0; i > 0 && column < columns; ++column) {
      const std::uint32_t right = (column + 1) % columns;
      AddQuad(below[column], below[right], row[right], row[column], mesh);
    }
    below = row;
  }
  return mesh;
}

Mesh TorusKnot(int p, int q, float major_radius, float minor_radius, float tube_radius, int rings,
               int sides) {
  const auto n = static_cast<std::uint32_t>(rings), m = static_cast<std::uint32_t>(sides);
  const auto centre = [&](double t) {
    const double r = major_radius + minor_radius * std::cos(q * t);
    return glm::dvec3(r * std::cos(p * t), minor_radius * std::sin(q * t), -r * std::sin(p * t));
  };
  Mesh mesh;
  for (std::uint32_t ring = 0; ring < n; ++ring) {
    const double t = glm::two_pi<double>() * ring / n;
    const glm::dvec3 tangent = glm::normalize(centre(t + 1e-4) - centre(t - 1e-4));
    // The frame is built from the direction away from the torus's core circle, which closes by
    // itself.
    const double r = major_radius;
    const glm::dvec3 core(r * std::cos(p * t), 0, -r * std::sin(p * t));
    const glm::dvec3 lean = minor_radius > 0 ? centre(t) - core : core;
    const glm::dvec3 side = glm::normalize(lean - tangent * glm::dot(lean, tangent));
    const glm::dvec3 up = glm::cross(tangent, side);
    for (std::uint32_t i = 0; i < m; ++i) {
      const double angle = glm::two_pi<double>() * i / m;
      const glm::dvec3 normal = std::cos(angle) * side + std::sin(angle) * up;
      mesh.normals.emplace_back(normal);
      mesh.positions.emplace_back(centre(t) + static_cast<double>(tube_radius) * normal);
      const std::uint32_t next_ring = (ring + 1) % n, next_side = (i + 1) % m;
      AddQuad(ring * m + i, ring * m + next_side, next_ring * m + next_side, next_ring * m + i,
              mesh);
    }
  }
  return mesh;
}

void Displace(Mesh& mesh, const std::function<float(const glm::vec3&)>& height) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.positions[i] += height(mesh.positions[i]) * mesh.normals[i];
  }
  mesh.normals = AreaWeightedNormals(mesh.positions, mesh.triangles);
}

}  // namespace skywave
