// Compares surface preparation with a double reference: normals, sides, lifted origins and colours.

#include "kernels/surface/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/support/random_rows.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

std::uint32_t Encode(Vec n) { return EncodeNormal(float(n.x), float(n.y), float(n.z)); }

// Decodes an octahedral normal in double (Cigolle et al. 2014).
Vec Decode(std::uint32_t packed) {
  const double x = std::int16_t(packed & 0xFFFFu) / 32767.0,
               y = std::int16_t(packed >> 16) / 32767.0;
  const double z = 1 - std::fabs(x) - std::fabs(y);
  if (z >= 0) return Unit({x, y, z});
  return Unit({std::copysign(1 - std::fabs(y), x), std::copysign(1 - std::fabs(x), y), z});
}

// Returns random directions, the axes, the folds of the octahedron and the lower half.
std::vector<Vec> Normals() {
  Random random(111);
  std::vector<Vec> normals;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x != 0 || y != 0 || z != 0) normals.push_back(Unit({double(x), double(y), double(z)}));
      }
    }
  }
  for (int i = 0; i < 200; ++i) {
    const double a = random.Between(-kPi, kPi), tiny = random.Between(-1e-5, 1e-5);
    normals.push_back(Unit({std::cos(a), std::sin(a), tiny}));  // the equator, where it folds
    normals.push_back(Unit({std::cos(a), tiny, std::sin(a)}));  // the edges, where a sign flips
    normals.push_back(Unit({tiny, std::cos(a), std::sin(a)}));
    normals.push_back(Unit({tiny, random.Between(-1e-5, 1e-5), a < 0 ? -1.0 : 1.0}));  // the poles
  }
  while (normals.size() < 40000) normals.push_back(random.Direction());
  return normals;
}

struct Rows {
  explicit Rows(std::uint32_t n)
      : surfaces(n), triangles(n), corners(3 * n + 1), positions(9 * n + 1), materials(4) {
    std::iota(corners.begin(), corners.end(), 0u);
    for (std::uint32_t m = 0; m < 4; ++m) {
      for (int c = 0; c < 3; ++c) materials[m].color[c] = 0.1f * float(m) + 0.01f * float(c);
    }
  }
  void Prepare(std::uint32_t n) {
    PrepareSurfaces({triangles.data(), corners.data(), positions.data(), instances},
                    materials.data(), n, surfaces);
  }
  void PutCorner(std::uint32_t triangle, std::size_t corner, Vec p) {
    float* const to = &positions[9 * std::size_t{triangle} + 3 * corner];
    to[0] = float(p.x), to[1] = float(p.y), to[2] = float(p.z);
  }
  Vec Corner(std::uint32_t triangle, std::size_t corner) const {
    const float* const p = &positions[9 * std::size_t{triangle} + 3 * corner];
    return {p[0], p[1], p[2]};
  }
  soa::Table<SurfaceColumns> surfaces;
  std::vector<TriangleRecord> triangles;
  std::vector<std::uint32_t> corners;
  std::vector<float> positions;
  const InstanceRecord* instances = nullptr;
  std::vector<MaterialRecord> materials;
};

TEST(EncodeNormal, IsOffByAtMost65Microradians) {
  const std::vector<Vec> normals = Normals();
  const auto n = std::uint32_t(normals.size());
  Rows rows(n);
  const SurfaceColumns& s = rows.surfaces;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t packed = Encode(normals[i]);
    rows.triangles[i] = {{packed, packed, packed}, 0};
    ASSERT_LT(Angle(Decode(packed), normals[i]), 6.5e-5) << "direction " << i;
    s.triangle[i] = i;
    s.u[i] = 0.25f, s.v[i] = 0.25f;
    Put(normals[i], i, s.wo_x, s.wo_y, s.wo_z);
    Put(3 * normals[i], i, s.ng_x, s.ng_y, s.ng_z);
  }
  // The kernels decode the encoded normals.
  rows.Prepare(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec ns = Get(i, s.ns_x, s.ns_y, s.ns_z);
    ASSERT_NEAR(Length(ns), 1, 1e-6);
    ASSERT_LT(Angle(ns, normals[i]), 6.55e-5) << "direction " << i;
    ASSERT_LT(Angle(Get(i, s.ng_x, s.ng_y, s.ng_z), normals[i]), 1e-6);
  }
}

TEST(EncodeNormal, KeepsTheAxes) {
  for (const Vec axis : {Vec{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}) {
    EXPECT_EQ(Angle(Decode(Encode(axis)), axis), 0);
  }
}

// Random hits of every kind: smooth and flat, from both sides, with normals that face away.
class PreparedRows : public testing::Test {
 protected:
  struct Hit {
    Vec wo, wound, corner[3];
    double u, v;
    bool flat;
    std::uint32_t material;
  };
  PreparedRows() : rows_(kFullWave) {
    Random random(112);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      Hit hit;
      hit.wo = random.Direction();
      const Vec ng = random.Direction();
      hit.wound = random.Between(0.01, 100) * ng;
      for (Vec& corner : hit.corner) {
        const std::uint32_t packed = Encode(Unit(ng + random.Between(0, 1.5) * random.Direction()));
        rows_.triangles[i].normal[&corner - hit.corner] = packed;
        corner = Decode(packed);
      }
      const Vec middle = random.Between(0, 1000) * random.Direction();
      const double size = std::pow(10, random.Between(-3, 3));
      for (std::size_t corner = 0; corner < 3; ++corner) {
        rows_.PutCorner(i, corner, middle + size * random.Direction());
      }
      hit.u = random.Between(0, 1), hit.v = random.Between(0, 1 - hit.u);
      hit.flat = i % 5 == 0;
      hit.material = random.Word() % 4;
      rows_.triangles[i].tag = hit.material | (hit.flat ? kFlatTriangle : 0) | 2u << kKindShift;
      hits_.push_back(hit);
    }
  }
  void Load(std::uint32_t n) {
    const SurfaceColumns& s = rows_.surfaces;
    FillWithGarbage(s, kFullWave);
    for (std::uint32_t i = 0; i < n; ++i) {
      const Hit& hit = hits_[i];
      Put(hit.wo, i, s.wo_x, s.wo_y, s.wo_z);
      Put(hit.wound, i, s.ng_x, s.ng_y, s.ng_z);
      s.u[i] = float(hit.u), s.v[i] = float(hit.v);
      s.triangle[i] = i;
    }
  }
  Rows rows_;
  std::vector<Hit> hits_;
};

TEST_F(PreparedRows, MatchTheReference) {
  const SurfaceColumns& s = rows_.surfaces;
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      Load(n);
      rows_.Prepare(n);
      std::uint32_t back_faces = 0, geometric = 0;
      for (std::uint32_t i = 0; i < n; ++i) {
        const Hit& hit = hits_[i];
        const double facing = Dot(hit.wound, hit.wo) / Length(hit.wound);
        if (std::fabs(facing) < 1e-6) continue;
        const bool back = facing < 0;
        back_faces += back;
        const Vec ng = back ? -Unit(hit.wound) : Unit(hit.wound);
        ASSERT_LT(Length(Get(i, s.ng_x, s.ng_y, s.ng_z) - ng), 1e-6) << "row " << i;
        ASSERT_EQ(s.material[i], hit.material | (back ? kBackFace : 0)) << "row " << i;

        const Vec sum =
            (1 - hit.u - hit.v) * hit.corner[0] + hit.u * hit.corner[1] + hit.v * hit.corner[2];
        const Vec ns = back ? -Unit(sum) : Unit(sum);
        const double side = Dot(ns, hit.wo);
        const bool uses_geometric = hit.flat || side <= 1e-4;
        // Sums of normals that cancel have only an absolute precision.
        const double tolerance = 2e-6 / Length(sum);
        if (hit.flat || std::fabs(side - 1e-4) > tolerance) {
          const Vec expected = uses_geometric ? ng : ns;
          ASSERT_LT(Length(Get(i, s.ns_x, s.ns_y, s.ns_z) - expected), tolerance + 1e-6)
              << "row " << i << (hit.flat ? ", flat" : "");
          geometric += uses_geometric;
        }
        ASSERT_GT(Dot(Get(i, s.ns_x, s.ns_y, s.ns_z), hit.wo), 0) << "row " << i;

        const float* color = rows_.materials[hit.material].color;
        ASSERT_EQ(s.color_r[i], color[0]);
        ASSERT_EQ(s.color_g[i], color[1]);
        ASSERT_EQ(s.color_b[i], color[2]);
      }
      if (n == kFullWave) {
        EXPECT_GT(back_faces, n / 3);
        EXPECT_GT(geometric, n / 5);
        EXPECT_LT(geometric, n / 2);
      }
    }
  });
}

// Origins of outgoing rays are means of the corners, whatever ray has found them, lifted along the
// normal to the eye's side by more than their rounding.
TEST_F(PreparedRows, OriginsAreOnTheTriangleLiftedToTheSideOfTheEye) {
  Load(kFullWave);
  rows_.Prepare(kFullWave);
  const SurfaceColumns& s = rows_.surfaces;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const Vec p0 = rows_.Corner(i, 0), p1 = rows_.Corner(i, 1), p2 = rows_.Corner(i, 2);
    const double u = s.u[i], v = s.v[i];
    const Vec exact = (1 - u - v) * p0 + u * p1 + v * p2;
    const double rounding =
        3e-7 * std::max({LargestCoordinate(p0), LargestCoordinate(p1), LargestCoordinate(p2)});
    const Vec off = Get(i, s.org_x, s.org_y, s.org_z) - exact;
    const Vec ng = Get(i, s.ng_x, s.ng_y, s.ng_z);
    ASSERT_LT(Length(off - double(s.lift[i]) * ng), rounding) << "row " << i;
    const double lift = Lift(LargestCoordinate(exact), p1 - p0, p2 - p0);
    ASSERT_NEAR(s.lift[i], lift, 1e-3 * lift) << "row " << i;
  }
}

// Corners of an object are taken to the world by the matrix of its instance, and edges count by the
// factor that they grow by.
TEST_F(PreparedRows, OriginsOnInstancesAreInTheWorld) {
  InstanceRecord records[2] = {};
  for (int axis = 0; axis < 3; ++axis) records[0].linear[4 * axis] = 1;
  records[0].scale = records[0].cofactors = 1;
  records[1] = {.linear = {0, -3, 0, 2, 0, 0, 0, 0, 5},
                .translation = {7, 8, -9},
                .extent = 4e4f,
                .scale = 5,
                .cofactors = 1.0f / 25,
                .unused = 0};
  rows_.instances = records;
  Load(kFullWave);
  const SurfaceColumns& s = rows_.surfaces;
  for (std::uint32_t i = 0; i < kFullWave; ++i) s.instance[i] = i % 2;
  rows_.Prepare(kFullWave);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const Vec p0 = rows_.Corner(i, 0), p1 = rows_.Corner(i, 1), p2 = rows_.Corner(i, 2);
    const double u = s.u[i], v = s.v[i], grown = i % 2 == 0 ? 1 : 5;
    const Vec in_object = (1 - u - v) * p0 + u * p1 + v * p2;
    const Vec moved = {-3 * in_object.y + 7, 2 * in_object.x + 8, 5 * in_object.z - 9};
    const Vec exact = i % 2 == 0 ? in_object : moved;
    const double extent = i % 2 == 0 ? LargestCoordinate(exact) : 4e4;
    const double lift = Lift(extent, grown * (p1 - p0), grown * (p2 - p0));
    ASSERT_NEAR(s.lift[i], lift, 1e-3 * lift) << "row " << i;
    const Vec off = Get(i, s.org_x, s.org_y, s.org_z) - exact;
    const Vec ng = Get(i, s.ng_x, s.ng_y, s.ng_z);
    ASSERT_LT(Length(off - double(s.lift[i]) * ng), 3e-2) << "row " << i;
  }
}

TEST_F(PreparedRows, BitsDoNotDependOnTarget) {
  ExpectSameOnEveryTarget([&] {
    Load(kFullWave);
    rows_.Prepare(kFullWave);
    return ColumnBits(rows_.surfaces.columns(), kFullWave);
  });
}

// If smooth normals cancel, the geometric normal is used.
TEST(PrepareSurfaces, OppositeNormalsFallBack) {
  Rows rows(1);
  const SurfaceColumns& s = rows.surfaces;
  rows.triangles[0] = {{Encode({1, 0, 0}), Encode({-1, 0, 0}), Encode({0, 0, 1})}, 0};
  s.u[0] = 0.5f, s.v[0] = 0;
  Put({0, 0, 1}, 0, s.wo_x, s.wo_y, s.wo_z);
  Put({0, 0, 2}, 0, s.ng_x, s.ng_y, s.ng_z);
  rows.Prepare(1);
  EXPECT_EQ(s.ns_x[0], 0);
  EXPECT_EQ(s.ns_y[0], 0);
  EXPECT_EQ(s.ns_z[0], 1);
}

// Tests the part of the triangle's tangent that lies in the surface, as the cosine and sine of its
// angle in the kernels' frame.
TEST(Tangents, LieInTheSurface) {
  constexpr std::uint32_t kRows = 1000;
  soa::Table<SurfaceColumns> surfaces(kRows);
  const SurfaceColumns& s = surfaces;
  Random random(117);
  std::vector<std::uint32_t> tangents(kRows);
  std::vector<Vec> normals(kRows);
  for (std::uint32_t i = 0; i < kRows; ++i) {
    normals[i] = random.Direction();
    Put(normals[i], i, s.ns_x, s.ns_y, s.ns_z);
    s.triangle[i] = kRows - 1 - i;
    tangents[s.triangle[i]] = Encode(random.Direction());
  }
  ForEachTarget([&] {
    for (const std::uint32_t n : {0u, 1u, 17u, kRows}) {
      std::fill_n(s.varying_0, kRows, 9.0f), std::fill_n(s.varying_1, kRows, 9.0f);
      PrepareTangents(tangents.data(), nullptr, n, surfaces);
      for (std::uint32_t i = 0; i < kRows; ++i) {
        if (i >= n) {
          ASSERT_EQ(s.varying_0[i] + s.varying_1[i], 18) << "row " << i << " of " << n;
          continue;
        }
        // The frame follows Duff et al. 2017.
        const Vec m = normals[i];
        const double sign = std::copysign(1.0, m.z), a = -1 / (sign + m.z);
        const Vec x = {1 + sign * m.x * m.x * a, sign * m.x * m.y * a, -sign * m.x};
        const Vec tangent = Decode(tangents[s.triangle[i]]);
        const Vec flat = Unit(tangent - Dot(tangent, m) * m);
        ASSERT_NEAR(s.varying_0[i], Dot(flat, x), 1e-4) << "row " << i;
        ASSERT_NEAR(s.varying_1[i], Dot(flat, Cross(m, x)), 1e-4) << "row " << i;
      }
    }
  });
  // A tangent along the normal has no such part, so the first axis of the frame is used.
  tangents[s.triangle[0]] = Encode(normals[0]);
  Put(Decode(tangents[s.triangle[0]]), 0, s.ns_x, s.ns_y, s.ns_z);
  PrepareTangents(tangents.data(), nullptr, 1, surfaces);
  EXPECT_EQ(s.varying_0[0], 1);
  EXPECT_EQ(s.varying_1[0], 0);
}

// Rows seen from inside are attenuated by exp(-k t); the others and those after the last row are
// unchanged.
TEST(Absorption, IsThatOfTheLengthInside) {
  constexpr std::uint32_t kRows = 1000;
  soa::Table<SurfaceColumns> surfaces(kRows);
  const SurfaceColumns& s = surfaces;
  Random random(118);
  std::vector<MaterialRecord> materials(5);
  for (MaterialRecord& material : materials) {
    for (float& k : material.k) k = float(random.Between(0, 3));
  }
  materials[0].k[0] = 0;
  for (std::uint32_t i = 0; i < kRows; ++i) {
    s.t[i] = float(random.Between(0, 8));
    s.material[i] = random.Word() % 5 | (i % 3 == 0 ? kBackFace : 0);
  }
  ForEachTarget([&] {
    for (const std::uint32_t n : {0u, 1u, 17u, kRows}) {
      for (float* column : {s.throughput_r, s.throughput_g, s.throughput_b}) {
        std::fill_n(column, kRows, 0.7f);
      }
      AbsorbInside(materials.data(), n, surfaces);
      for (std::uint32_t i = 0; i < kRows; ++i) {
        const MaterialRecord& material = materials[s.material[i] & kMaterialMask];
        const double length = i < n && i % 3 == 0 ? s.t[i] : 0;
        const float* const seen[3] = {s.throughput_r, s.throughput_g, s.throughput_b};
        for (int c = 0; c < 3; ++c) {
          // An exponent of up to 35 is rounded to 2^-24 of its value.
          const double expected = 0.7f * std::exp(-material.k[c] * length);
          ASSERT_NEAR(seen[c][i], expected, 5e-6 * expected) << "row " << i << " of " << n;
        }
      }
    }
  });
}

}  // namespace
}  // namespace skywave
