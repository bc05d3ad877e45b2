// Tests that points of triangles are moved to the round surface that normals of corners mean.
#include "kernels/surface/terminator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "tests/support/random_rows.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

// Triangles with their corners on the unit sphere, whose normals are those of the sphere; every
// third one is flat.
class OnASphere : public testing::Test {
 protected:
  OnASphere()
      : surfaces_(kFullWave),
        triangles_(kFullWave),
        corners_(3 * kFullWave + 1),
        positions_(9 * kFullWave + 1),
        materials_(1) {
    std::iota(corners_.begin(), corners_.end(), 0u);
    Random random(131);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const Vec middle = random.Direction();
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec corner = Unit(middle + 0.4 * random.Direction());
        Put(corner, 9 * i + 3 * std::uint32_t(c), &positions_[0], &positions_[1], &positions_[2]);
        triangles_[i].normal[c] = EncodeNormal(float(corner.x), float(corner.y), float(corner.z));
      }
      triangles_[i].tag = i % 3 == 0 ? kFlatTriangle : 0;
      if (Dot(Normal(i), middle) < 0) {  // counter-clockwise from outside
        std::swap(corners_[3 * i], corners_[3 * i + 1]);
        std::swap(triangles_[i].normal[0], triangles_[i].normal[1]);
      }
      u_.push_back(random.Between(0, 1));
      v_.push_back(random.Between(0, 1 - u_.back()));
      // Every fourth one is seen from inside.
      wo_.push_back((i % 4 == 0 ? -1.0 : 1.0) * Unit(middle + 0.5 * random.Direction()));
    }
  }

  Vec Corner(std::uint32_t triangle, std::size_t corner) const {
    const float* const p = &positions_[3 * std::size_t{corners_[3 * triangle + corner]}];
    return {p[0], p[1], p[2]};
  }
  Vec Normal(std::uint32_t triangle) const {
    const Vec p0 = Corner(triangle, 0);
    return Unit(Cross(Corner(triangle, 1) - p0, Corner(triangle, 2) - p0));
  }
  Vec Point(std::uint32_t i) const {
    return (1 - u_[i] - v_[i]) * Corner(i, 0) + u_[i] * Corner(i, 1) + v_[i] * Corner(i, 2);
  }
  bool IsFlat(std::uint32_t i) const { return (triangles_[i].tag & kFlatTriangle) != 0; }

  void Prepare(std::uint32_t n) {
    const SurfaceColumns& s = surfaces_;
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      Put(wo_[i], i, s.wo_x, s.wo_y, s.wo_z);
      Put(Normal(i), i, s.ng_x, s.ng_y, s.ng_z);
      s.u[i] = float(u_[i]), s.v[i] = float(v_[i]), s.triangle[i] = i;
      s.instance[i] = 1;
    }
    const TriangleTables tables = {triangles_.data(), corners_.data(), positions_.data(),
                                   instances_};
    PrepareSurfaces(tables, materials_.data(), kFullWave, surfaces_);
    RoundSurfaces(tables, n, surfaces_);
  }

  soa::Table<SurfaceColumns> surfaces_;
  std::vector<TriangleRecord> triangles_;
  std::vector<std::uint32_t> corners_;
  std::vector<float> positions_;
  std::vector<MaterialRecord> materials_;
  const InstanceRecord* instances_ = nullptr;
  std::vector<double> u_, v_;
  std::vector<Vec> wo_;
};

// The mean of the planes that touch a sphere at the corners lies outside of it: rays along the
// horizon of the smooth normal miss the triangles.
TEST_F(OnASphere, PointsSeenFromOutsideRiseToThePlanesOfTheCorners) {
  const SurfaceColumns& s = surfaces_;
  ForEachTarget([&] {
    Prepare(kFullWave);
    std::uint32_t rounded = 0;
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const Vec at = Get(i, s.org_x, s.org_y, s.org_z), ng = Get(i, s.ng_x, s.ng_y, s.ng_z);
      const bool inside = (s.material[i] & kBackFace) != 0;
      if (IsFlat(i) || inside) continue;
      Vec mean = (1 - u_[i] - v_[i]) * Corner(i, 0) + u_[i] * Corner(i, 1) + v_[i] * Corner(i, 2);
      mean = Unit(mean);
      if (Dot(mean, wo_[i]) < 1e-3) continue;
      ASSERT_LT(Length(ng - mean), 2e-4) << "row " << i;
      const Vec point = Point(i);
      const double shares[] = {1 - u_[i] - v_[i], u_[i], v_[i]};
      Vec expected = point + double(s.lift[i]) * mean;
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec corner = Corner(i, c);
        expected = expected + shares[c] * std::max(0.0, Dot(corner - point, corner)) * corner;
      }
      ASSERT_LT(Length(at - expected), 2e-4) << "row " << i;
      ASSERT_GT(Length(at), 1 - 1e-4) << "row " << i;
      ++rounded;
    }
    EXPECT_GT(rounded, kFullWave / 4);
  });
}

TEST_F(OnASphere, PointsOfFlatTrianglesStay) {
  Prepare(0);
  const SurfaceColumns& s = surfaces_;
  std::vector<Vec> places, normals;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    places.push_back(Get(i, s.org_x, s.org_y, s.org_z));
    normals.push_back(Get(i, s.ng_x, s.ng_y, s.ng_z));
  }
  constexpr std::uint32_t kRows = kFullWave - 5;
  ForEachTarget([&] {
    Prepare(kRows);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      if (!IsFlat(i) && i < kRows) continue;
      ASSERT_EQ(Length(Get(i, s.org_x, s.org_y, s.org_z) - places[i]), 0) << "row " << i;
      ASSERT_EQ(Length(Get(i, s.ng_x, s.ng_y, s.ng_z) - normals[i]), 0) << "row " << i;
    }
  });
}

// From inside, the planes through the corners lie behind the triangle.
TEST_F(OnASphere, PointsSeenFromInsideStayOnTheTriangle) {
  Prepare(kFullWave);
  const SurfaceColumns& s = surfaces_;
  std::uint32_t inside = 0;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    if ((s.material[i] & kBackFace) == 0) continue;
    ++inside;
    const Vec at = Get(i, s.org_x, s.org_y, s.org_z);
    ASSERT_LT(Length(at - Point(i)), 1.01 * double(s.lift[i]) + 1e-6) << "row " << i;
  }
  EXPECT_GT(inside, kFullWave / 8);
}

// An ellipsoid that an instance makes of the sphere, mirrored: its points rise by the matrix.
TEST_F(OnASphere, InstancesMoveWhatRises) {
  Prepare(kFullWave);
  const SurfaceColumns& s = surfaces_;
  std::vector<Vec> rises;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    rises.push_back(Get(i, s.org_x, s.org_y, s.org_z) - Point(i));
  }
  InstanceRecord records[2] = {};
  records[1] = {.linear = {0, -3, 0, 2, 0, 0, 0, 0, 5},
                .translation = {7, 8, -9},
                .extent = 12,
                .scale = 5,
                .cofactors = 1.0f / 25,
                .unused = 0};
  instances_ = records;
  for (Vec& wo : wo_) wo = Unit({-3 * wo.y, 2 * wo.x, 5 * wo.z});
  Prepare(kFullWave);
  std::uint32_t rounded = 0;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const bool as_before = !IsFlat(i) && Length(rises[i]) > 1e-4;
    if (!as_before || Dot(Get(i, s.ng_x, s.ng_y, s.ng_z), wo_[i]) < 0.1) continue;
    const Vec p = Point(i) + rises[i];
    const Vec expected = {-3 * p.y + 7, 2 * p.x + 8, 5 * p.z - 9};
    const Vec off = Get(i, s.org_x, s.org_y, s.org_z) - expected;
    // Rows whose side or use of normals has changed are those near the silhouette.
    if (Length(off) < 1e-3) ++rounded;
  }
  EXPECT_GT(rounded, kFullWave / 4);
}

TEST_F(OnASphere, BitsDoNotDependOnTarget) {
  ExpectSameOnEveryTarget([&] {
    Prepare(kFullWave);
    return ColumnBits(surfaces_.columns(), kFullWave);
  });
}

}  // namespace
}  // namespace skywave
