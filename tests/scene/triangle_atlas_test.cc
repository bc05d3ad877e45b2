// Tests images of which each triangle has a square: squares share nothing, are as fine as they may
// be, and lookups inside a triangle stay in its own.
#include "scene/shapes/triangle_atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <vector>

namespace skywave {
namespace {

constexpr std::size_t kPlenty = std::size_t{1} << 22;

// Returns a mesh of right triangles whose longest edges have these lengths.
Mesh TrianglesOf(const std::vector<float>& lengths) {
  Mesh mesh;
  for (const float length : lengths) {
    const auto first = std::uint32_t(mesh.positions.size());
    const float side = length / std::sqrt(2.0f);
    mesh.positions.insert(mesh.positions.end(), {{0, 0, 0}, {side, 0, 0}, {0, side, 0}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

// Returns `count` lengths of all sizes from 0.001 to 1.
std::vector<float> ManyLengths(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> exponent(-3, 0);
  std::vector<float> lengths = {1};
  while (int(lengths.size()) < count) lengths.push_back(std::pow(10.0f, exponent(random)));
  return lengths;
}

std::size_t Texels(const TriangleAtlas& atlas) {
  std::size_t sum = 0;
  for (const AtlasSquare& square : atlas.squares) {
    sum += std::size_t(square.side) * std::size_t(square.side);
  }
  return sum;
}

TEST(TriangleAtlas, SquaresShareNothing) {
  for (const int count : {1, 2, 3, 7, 500}) {
    SCOPED_TRACE(count);
    const TriangleAtlas atlas = MakeTriangleAtlas(TrianglesOf(ManyLengths(count)), kPlenty);
    ASSERT_EQ(atlas.squares.size(), std::size_t(count));
    std::vector<bool> taken(std::size_t(atlas.size.x) * std::size_t(atlas.size.y));
    for (const AtlasSquare& square : atlas.squares) {
      ASSERT_TRUE(std::has_single_bit(unsigned(square.side)));
      ASSERT_GE(std::min(square.corner.x, square.corner.y), 0);
      ASSERT_LE(square.corner.x + square.side, atlas.size.x);
      ASSERT_LE(square.corner.y + square.side, atlas.size.y);
      for (int y = 0; y < square.side; ++y) {
        for (int x = 0; x < square.side; ++x) {
          const std::size_t at = std::size_t(square.corner.y + y) * std::size_t(atlas.size.x) +
                                 std::size_t(square.corner.x + x);
          ASSERT_FALSE(taken[at]);
          taken[at] = true;
        }
      }
    }
    EXPECT_LT(taken.size(), 2 * Texels(atlas));
  }
}

// Sides are powers of two, so texels are as large as the coarsest allowed ones or half as large,
// but for triangles that have the least or the most.
TEST(TriangleAtlas, GivesLengthItsTexels) {
  const std::vector<float> lengths = ManyLengths(300);
  const TriangleAtlas atlas = MakeTriangleAtlas(TrianglesOf(lengths), kPlenty);
  EXPECT_LE(Texels(atlas), kPlenty);
  EXPECT_GT(Texels(atlas), kPlenty / 4);
  float finest = 0, coarsest = 1e9f;  // texels per length
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const int side = atlas.squares[i].side;
    if (side > 4) finest = std::max(finest, float(side) / lengths[i]);
    if (side < 1024) coarsest = std::min(coarsest, float(side) / lengths[i]);
  }
  EXPECT_LT(finest, 2.002f * coarsest);
}

// The largest squares do not keep small triangles from texels that are left.
TEST(TriangleAtlas, GivesSmallTrianglesWhatIsLeft) {
  std::vector<float> lengths(4002, 0.001f);
  lengths[0] = lengths[1] = 1;
  const TriangleAtlas atlas = MakeTriangleAtlas(TrianglesOf(lengths), kPlenty);
  EXPECT_EQ(atlas.squares[0].side, 1024);
  EXPECT_EQ(atlas.squares[2].side, 16);
}

TEST(TriangleAtlas, TakesAllThatItMayAndNoMore) {
  const Mesh mesh = TrianglesOf(std::vector<float>(100, 1.0f));
  EXPECT_EQ(MakeTriangleAtlas(mesh, 100 * 64 * 64).squares[0].side, 64);
  EXPECT_EQ(MakeTriangleAtlas(mesh, 100 * 64 * 64 - 1).squares[0].side, 32);
  EXPECT_EQ(MakeTriangleAtlas(mesh, std::size_t{1} << 40).squares[0].side, 1024);
  EXPECT_EQ(MakeTriangleAtlas(mesh, 100 * 4 * 4).squares[0].side, 4);
  EXPECT_EQ(MakeTriangleAtlas(mesh, 100 * 4 * 4 - 1).size, glm::ivec2(0));
  EXPECT_EQ(MakeTriangleAtlas(Mesh(), kPlenty).size, glm::ivec2(0));
}

// Triangles without extent show one place.
TEST(TriangleAtlas, HasRoomForPoints) {
  EXPECT_EQ(MakeTriangleAtlas(TrianglesOf({0, 0}), kPlenty).squares[0].side, 4);
  EXPECT_EQ(MakeTriangleAtlas(TrianglesOf({1, 0}), kPlenty).squares[1].side, 4);
}

// A bilinear lookup reads the four texels whose centres are around a place.
TEST(TriangleAtlas, LookupsStayInTheirSquare) {
  const std::vector<float> lengths = ManyLengths(50);
  Mesh mesh = TrianglesOf(lengths);
  const TriangleAtlas atlas = MakeTriangleAtlas(mesh, kPlenty);
  LayOutTriangles(atlas, mesh);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const AtlasSquare& square = atlas.squares[t];
    glm::vec2 low(1e9f), high(-1e9f);
    for (int i = 0; i < 200; ++i) {
      // The first three are the corners.
      glm::vec3 weights(i == 0, i == 1, i == 2);
      if (i > 2) weights = {uniform(random), uniform(random), uniform(random)};
      weights /= weights.x + weights.y + weights.z;
      glm::vec2 uv(0);
      for (int c = 0; c < 3; ++c) uv += weights[c] * mesh.uvs[mesh.triangles[t][c]];
      const glm::vec2 at = glm::vec2(uv.x, 1 - uv.y) * glm::vec2(atlas.size) - 0.5f;
      low = glm::min(low, at), high = glm::max(high, at);
    }
    // Coordinates are floats; those of an image of 2048 texels are rounded to 2^-13 of a texel.
    const glm::vec2 corner(square.corner);
    ASSERT_GE(std::min(low.x - corner.x, low.y - corner.y), -1e-3f);
    ASSERT_LE(std::max(high.x - corner.x, high.y - corner.y), float(square.side - 1) + 1e-3f);
    // The triangle spans its square.
    EXPECT_NEAR(high.x - low.x, float(square.side - 1), 1e-2f);
    EXPECT_NEAR(high.y - low.y, float(square.side - 1), 1e-2f);
  }
}

}  // namespace
}  // namespace skywave
