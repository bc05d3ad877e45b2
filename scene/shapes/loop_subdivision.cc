#include "scene/shapes/loop_subdivision.h"

#include <cmath>
#include <cstdint>
#include <glm/gtc/constants.hpp>
#include <unordered_map>
#include <utility>

#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// Edge i of a triangle connects corners i and (i + 1) % 3; corner (i + 2) % 3 is opposite.
struct Edges {
  std::vector<glm::uvec2> vertices;  // per edge
  std::vector<glm::uvec2> sides;     // per edge: 3 * triangle + edge of two triangles, or kNone
  std::vector<std::uint32_t> triangle_count;  // per edge
  std::vector<std::uint32_t> of_side;         // per 3 * triangle + edge: index of the edge
};

bool IsBoundary(const Edges& edges, std::uint32_t edge) { return edges.triangle_count[edge] != 2; }

Edges FindEdges(const std::vector<glm::uvec3>& triangles) {
  Edges edges;
  edges.of_side.resize(3 * triangles.size());
  std::unordered_map<std::uint64_t, std::uint32_t> known;
  known.reserve(triangles.size() * 3 / 2 + 1);
  for (std::uint32_t side = 0; side < edges.of_side.size(); ++side) {
    const glm::uvec3& t = triangles[side / 3];
    const std::uint32_t a = t[side % 3], b = t[(side % 3 + 1) % 3];
    const std::uint64_t key = a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
    const auto [found, is_new] =
        known.try_emplace(key, static_cast<std::uint32_t>(edges.vertices.size()));
    const std::uint32_t edge = found->second;
    if (is_new) {
      edges.vertices.emplace_back(a, b);
      edges.sides.emplace_back(side, kNone);
      edges.triangle_count.push_back(1);
    } else {
      if (++edges.triangle_count[edge] == 2) edges.sides[edge].y = side;
    }
    edges.of_side[side] = edge;
  }
  return edges;
}

// Sums over a vertex's neighbours for the masks; none depends on their order.
struct Neighbourhood {
  std::vector<std::uint32_t> valence;         // number of edges that end here
  std::vector<std::uint32_t> boundary_edges;  // number of boundary edges among them
  std::vector<glm::dvec3> sum;                // sum of the neighbours
  std::vector<glm::dvec3> boundary_sum;       // sum of the neighbours along boundary edges
};

Neighbourhood GatherNeighbours(const std::vector<glm::dvec3>& positions, const Edges& edges) {
  const std::size_t n = positions.size();
  Neighbourhood around{std::vector<std::uint32_t>(n), std::vector<std::uint32_t>(n),
                       std::vector<glm::dvec3>(n, glm::dvec3(0)),
                       std::vector<glm::dvec3>(n, glm::dvec3(0))};
  for (std::uint32_t edge = 0; edge < edges.vertices.size(); ++edge) {
    const glm::uvec2 ends = edges.vertices[edge];
    for (int i = 0; i < 2; ++i) {
      const std::uint32_t here = ends[i], there = ends[1 - i];
      ++around.valence[here];
      around.sum[here] += positions[there];
      if (IsBoundary(edges, edge)) {
        ++around.boundary_edges[here];
        around.boundary_sum[here] += positions[there];
      }
    }
  }
  return around;
}

// Returns Warren's choice of Loop's weight of one neighbour.
double Beta(std::uint32_t valence) { return valence == 3 ? 3.0 / 16 : 3.0 / (8.0 * valence); }

// `interior`(valence) and `boundary` are the weights of one neighbour; the vertex has the rest.
template <typename Weight>
std::vector<glm::dvec3> SmoothVertices(const std::vector<glm::dvec3>& positions,
                                       const Neighbourhood& around, Weight interior,
                                       double boundary) {
  std::vector<glm::dvec3> smooth(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const std::uint32_t n = around.valence[v];
    if (n > 0 && around.boundary_edges[v] == 0) {
      const double weight = interior(n);
      smooth[v] = (1 - n * weight) * positions[v] + weight * around.sum[v];
    } else if (around.boundary_edges[v] == 2) {
      smooth[v] = (1 - 2 * boundary) * positions[v] + boundary * around.boundary_sum[v];
    } else {
      smooth[v] = positions[v];
    }
  }
  return smooth;
}

void SubdivideOnce(std::vector<glm::dvec3>& positions, std::vector<glm::uvec3>& triangles) {
  const Edges edges = FindEdges(triangles);
  std::vector<glm::dvec3> finer =
      SmoothVertices(positions, GatherNeighbours(positions, edges), Beta, 1.0 / 8);
  const auto first_edge_vertex = static_cast<std::uint32_t>(finer.size());
  finer.reserve(finer.size() + edges.vertices.size());
  const auto opposite = [&](std::uint32_t side) {
    return positions[triangles[side / 3][(side % 3 + 2) % 3]];
  };
  for (std::uint32_t edge = 0; edge < edges.vertices.size(); ++edge) {
    const glm::dvec3 ends = positions[edges.vertices[edge].x] + positions[edges.vertices[edge].y];
    const glm::uvec2 sides = edges.sides[edge];
    finer.push_back(IsBoundary(edges, edge)
                        ? 0.5 * ends
                        : 3.0 / 8 * ends + 1.0 / 8 * (opposite(sides.x) + opposite(sides.y)));
  }
  std::vector<glm::uvec3> children;
  children.reserve(4 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const glm::uvec3 v = triangles[t];
    const glm::uvec3 m(first_edge_vertex + edges.of_side[3 * t],
                       first_edge_vertex + edges.of_side[3 * t + 1],
                       first_edge_vertex + edges.of_side[3 * t + 2]);
    children.emplace_back(v.x, m.x, m.z);
    children.emplace_back(m.x, v.y, m.y);
    children.emplace_back(m.z, m.y, v.z);
    children.push_back(m);
  }
  positions = std::move(finer);
  triangles = std::move(children);
}

// Collects the neighbours of `vertex` in order around it, in the orientation of the triangles that
// are visited. `first` is a side that begins at `vertex`; at a boundary it must lie on the boundary
// itself. Neighbouring triangles are found through edges, so inconsistent windings do no harm.
void WalkRing(const Edges& edges, std::uint32_t vertex, std::uint32_t first,
              std::vector<std::uint32_t>& ring) {
  ring.clear();
  const std::uint32_t first_edge = edges.of_side[first];
  std::uint32_t side = first;  // the side by which the current triangle was entered
  while (true) {
    const std::uint32_t t = side / 3;
    const glm::uvec2 ends = edges.vertices[edges.of_side[side]];
    ring.push_back(ends.x == vertex ? ends.y : ends.x);
    // The walk leaves through the triangle's other side at `vertex`.
    std::uint32_t out = 3 * t;
    while (out == side || (edges.vertices[edges.of_side[out]].x != vertex &&
                           edges.vertices[edges.of_side[out]].y != vertex)) {
      ++out;
    }
    const std::uint32_t edge = edges.of_side[out];
    if (edge == first_edge) return;
    if (IsBoundary(edges, edge)) {
      const glm::uvec2 last = edges.vertices[edge];
      ring.push_back(last.x == vertex ? last.y : last.x);
      return;
    }
    side = edges.sides[edge].x == out ? edges.sides[edge].y : edges.sides[edge].x;
  }
}

// Returns the cross product of two tangents, each a left eigenvector of the vertex's subdivision
// matrix applied to control points (the method of Hoppe et al. 1994).
//
// In the interior these are the cosines and sines around the ring. On a boundary with neighbours 0
// .. n-1 the tangent along it is p[0] - p[n-1]. Across it, the interior rows require sin(i theta)
// with theta = pi / (n - 1) and eigenvalue lambda = 3/8 + cos(theta) / 4; the columns of the two
// boundary neighbours (weight a) and of the vertex (weight c) then give
//   (lambda - 1/2) a = (c + sin theta) / 8,   (lambda - 3/4) c = a + 3/8 sum_i sin(i theta).
// For n = 4, the regular case, this is the known mask (-1 2 2 -1; -2).
glm::dvec3 LimitNormal(const std::vector<glm::dvec3>& positions, std::uint32_t vertex,
                       const std::vector<std::uint32_t>& ring, bool boundary) {
  const std::size_t n = ring.size();
  // Positions are relative to the vertex, so that a distant origin costs no digits: the weights sum
  // to zero.
  const auto neighbour = [&](std::size_t i) { return positions[ring[i]] - positions[vertex]; };
  glm::dvec3 s(0), t(0);
  if (!boundary) {
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = glm::two_pi<double>() * i / n;
      s += std::cos(angle) * neighbour(i);
      t += std::sin(angle) * neighbour(i);
    }
    return glm::cross(s, t);
  }
  s = neighbour(0) - neighbour(n - 1);
  if (n == 2) {
    t = neighbour(0) + neighbour(1);
  } else {
    const double theta = glm::pi<double>() / (n - 1);
    const double lambda = 3.0 / 8 + std::cos(theta) / 4;
    double sum = 0;
    for (std::size_t i = 1; i + 1 < n; ++i) {
      sum += std::sin(i * theta);
      t += std::sin(i * theta) * neighbour(i);
    }
    const double a = (3.0 / 8 * sum + (lambda - 0.75) * std::sin(theta)) /
                     (8 * (lambda - 0.5) * (lambda - 0.75) - 1);
    t += a * (neighbour(0) + neighbour(n - 1));
  }
  return glm::cross(s, t);
}

std::vector<glm::vec3> LimitNormals(const std::vector<glm::dvec3>& positions,
                                    const std::vector<glm::uvec3>& triangles, const Edges& edges,
                                    const Neighbourhood& around,
                                    std::vector<glm::vec3> fallback_normals) {
  // Each walk begins at one of these sides. A boundary ring has to begin where the triangle, read
  // in its own winding, has the boundary behind it: then the walk visits the neighbours in the
  // winding's order.
  std::vector<std::uint32_t> first_side(positions.size(), kNone);
  for (std::uint32_t side = 0; side < edges.of_side.size(); ++side) {
    const std::uint32_t vertex = triangles[side / 3][side % 3];
    if (first_side[vertex] == kNone || IsBoundary(edges, edges.of_side[side])) {
      first_side[vertex] = side;
    }
  }
  std::vector<glm::vec3> normals = std::move(fallback_normals);
  std::vector<std::uint32_t> ring;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const bool boundary = around.boundary_edges[v] > 0;
    const bool regular = around.boundary_edges[v] == 0 || around.boundary_edges[v] == 2;
    if (first_side[v] == kNone || !regular) continue;
    if (boundary && !IsBoundary(edges, edges.of_side[first_side[v]])) continue;
    WalkRing(edges, v, first_side[v], ring);
    if (ring.size() != around.valence[v]) continue;  // several fans meet here
    const glm::dvec3 normal = LimitNormal(positions, v, ring, boundary);
    const double length = glm::length(normal);
    if (length > 0) normals[v] = normal / length;
  }
  return normals;
}

}  // namespace

Mesh LoopSubdivide(const std::vector<glm::vec3>& positions,
                   const std::vector<glm::uvec3>& triangles, int levels) {
  std::vector<glm::dvec3> points(positions.begin(), positions.end());
  Mesh mesh;
  // A triangle that uses a vertex twice has no area and no ring, so it is removed.
  for (const glm::uvec3& t : triangles) {
    if (t.x != t.y && t.y != t.z && t.z != t.x) mesh.triangles.push_back(t);
  }
  for (int level = 0; level < levels; ++level) SubdivideOnce(points, mesh.triangles);

  const Edges edges = FindEdges(mesh.triangles);
  const Neighbourhood around = GatherNeighbours(points, edges);
  // These weights give the limit of repeated smoothing: 1 / (n + 3 / (8 beta)) inside, (1 4 1) / 6
  // of the uniform cubic B-spline on boundaries.
  const std::vector<glm::dvec3> limit = SmoothVertices(
      points, around, [](std::uint32_t n) { return 1 / (n + 3 / (8 * Beta(n))); }, 1.0 / 6);
  mesh.positions.assign(limit.begin(), limit.end());
  mesh.normals = LimitNormals(points, mesh.triangles, edges, around,
                              AreaWeightedNormals(mesh.positions, mesh.triangles));
  return mesh;
}

}  // namespace skywave
