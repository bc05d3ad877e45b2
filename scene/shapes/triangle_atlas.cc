#include "scene/shapes/triangle_atlas.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

constexpr int kLeastSide = 4, kMostSide = 1024;
// The side that the longest edge would have at the finest scale, if squares had no largest side.
constexpr unsigned kFinestScale = 1u << 20;

double LongestEdge(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 p[3] = {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
  return std::max(
      {glm::distance(p[0], p[1]), glm::distance(p[1], p[2]), glm::distance(p[2], p[0])});
}

// Returns the bits 0, 2, 4, ... of a number next to each other.
int EvenBits(std::size_t bits) {
  int even = 0;
  for (int i = 0; bits >> 2 * i != 0; ++i) even |= int(bits >> 2 * i & 1) << i;
  return even;
}

std::size_t Area(const AtlasSquare& square) {
  return std::size_t(square.side) * std::size_t(square.side);
}

// Squares of powers of two, the largest first, fill a Morton curve without gaps.
void PlaceSquares(TriangleAtlas& atlas) {
  std::vector<std::uint32_t> order(atlas.squares.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return atlas.squares[a].side > atlas.squares[b].side;
  });
  std::size_t next = 0;  // texel of the curve
  for (const std::uint32_t i : order) {
    AtlasSquare& square = atlas.squares[i];
    square.corner = {EvenBits(next), EvenBits(next >> 1)};
    next += Area(square);
  }
  // With an odd number of bits, x has one more than y.
  const auto area = std::bit_ceil(next);
  const int bits = std::countr_zero(area);
  atlas.size = {1 << (bits + 1) / 2, 1 << bits / 2};
}

}  // namespace

TriangleAtlas MakeTriangleAtlas(const Mesh& mesh, std::size_t most) {
  constexpr std::size_t kLeastArea = kLeastSide * kLeastSide;
  if (mesh.triangles.empty() || mesh.triangles.size() > most / kLeastArea) return {};
  std::vector<double> edges;
  edges.reserve(mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) edges.push_back(LongestEdge(mesh, t));
  const double longest = *std::max_element(edges.begin(), edges.end());
  TriangleAtlas atlas;
  atlas.squares.resize(edges.size());
  for (unsigned scale = kFinestScale; scale >= kLeastSide; scale /= 2) {
    std::size_t texels = 0;
    for (std::size_t t = 0; t < edges.size(); ++t) {
      const double share = longest > 0 ? edges[t] / longest : 0;
      const auto side = std::bit_ceil(unsigned(std::ceil(share * scale)));
      atlas.squares[t].side = std::clamp(int(side), kLeastSide, kMostSide);
      texels += Area(atlas.squares[t]);
    }
    if (texels > most) continue;
    PlaceSquares(atlas);
    return atlas;
  }
  return {};
}

void LayOutTriangles(const TriangleAtlas& atlas, Mesh& mesh) {
  GiveCornersUvs(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const AtlasSquare& square = atlas.squares[t];
    for (int i = 0; i < 3; ++i) {
      glm::vec2& uv = mesh.uvs[mesh.triangles[t][i]];
      const glm::dvec2 at = glm::dvec2(square.corner) + 0.5 +
                            glm::dvec2(uv.x, 1 - double(uv.y)) * double(square.side - 1);
      uv = {at.x / atlas.size.x, 1 - at.y / atlas.size.y};
    }
  }
}

}  // namespace skywave
