// Tests the transport of flux: compares the throughput of light paths at a surface with that of
// camera paths in reverse.

#include "kernels/light_paths/flux.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/bsdf_cases.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

const Vec kNormal = Unit({0.5, -0.3, -0.7});

std::vector<MaterialCase> AllCases() {
  std::vector<MaterialCase> cases = DenseCases();
  cases.insert(cases.end(), DeltaCases().begin(), DeltaCases().end());
  return cases;
}

// Returns the near index over the far index, or 1 if nothing is refracted.
double Ratio(const MaterialCase& material) {
  if (!Bsdfs()[std::size_t(material.kind)].refracts) return 1;
  return material.back ? double(material.record.ior) : 1.0 / material.record.ior;
}

// The kernel that divides by the squared ratio receives the ratio as a float.
constexpr double kRounding = 1e-5;

class Flux : public testing::TestWithParam<std::size_t> {
 protected:
  Flux() : material_(AllCases()[GetParam()]), rows_(material_, kFullWave, kNormal, kNormal) {}
  // Creates surfaces seen from random directions; shading normals deviate by `bend`.
  void Bend(double bend) {
    Random random(71);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const Vec ns = Unit(kNormal + bend * random.Direction());
      Vec wo = random.DirectionAbout(kNormal);
      if (Dot(wo, ns) < 0.02 || Dot(wo, kNormal) < 0.02) wo = Unit(kNormal + ns);
      rows_.Set(i, ns, bend == 0 ? ns : kNormal, wo);
    }
  }
  soa::Table<RayColumns> Scatter(const ScatterPolicy& policy, std::uint32_t* alive) const {
    soa::Table<RayColumns> rays(kFullWave);
    const ScatterRows uniforms(kFullWave, 73);
    *alive = rows_.kernels.scatter(rows_.surfaces, rows_.materials(), uniforms.view(), kFullWave,
                                   policy, rays, 0);
    return rays;
  }
  // Returns the factor of Veach 1997, eq. 5.19 and eq. 5.14, in double.
  double Factor(std::uint32_t row, Vec wi) const {
    const SurfaceColumns& s = rows_.surfaces;
    const Vec ns = Get(row, s.ns_x, s.ns_y, s.ns_z), ng = Get(row, s.ng_x, s.ng_y, s.ng_z);
    const Vec wo = Get(row, s.wo_x, s.wo_y, s.wo_z);
    const double bent = std::fabs(Dot(wo, ns) * Dot(wi, ng)) / std::fabs(Dot(wo, ng) * Dot(wi, ns));
    const double ratio = Dot(ng, wi) < 0 ? Ratio(material_) : 1;
    return bent / (ratio * ratio);
  }

  MaterialCase material_;
  ShadingRows rows_;
};

// If the two normals are equal, flux and radiance differ by refraction only.
TEST_P(Flux, OnFlatNormalsIsRadiance) {
  Bend(0);
  std::uint32_t n = 0, m = 0, through = 0;
  const auto radiance = Scatter({}, &n), flux = Scatter({.transport = Transport::kFlux}, &m);
  ASSERT_EQ(n, m);
  ASSERT_GT(n, kFullWave / 4);
  for (std::uint32_t i = 0; i < n; ++i) {
    ASSERT_EQ(flux->dir_x[i], radiance->dir_x[i]);
    ASSERT_EQ(flux->pdf[i], radiance->pdf[i]);
    const bool below = Dot(kNormal, RayDirection(flux, i)) < 0;
    through += below;
    const double ratio = below ? Ratio(material_) : 1;
    if (ratio == 1) {
      ASSERT_EQ(flux->throughput_g[i], radiance->throughput_g[i]) << "ray " << i;
    }
    ASSERT_NEAR(flux->throughput_g[i] * ratio * ratio, radiance->throughput_g[i],
                kRounding * radiance->throughput_g[i]);
  }
  EXPECT_EQ(through > 0, rows_.kernels.transmits);
}

TEST_P(Flux, OnBentNormalsHasVeachsFactor) {
  Bend(0.6);
  std::uint32_t n = 0, m = 0;
  const auto radiance = Scatter({}, &n), flux = Scatter({.transport = Transport::kFlux}, &m);
  ASSERT_EQ(n, m);
  double most = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t from = flux->from[i];
    const Vec wi = RayDirection(flux, i);
    double factor = Factor(from, wi);
    if (rows_.kernels.delta) {
      // Delta BSDFs use the geometric normal if the reflection would go into the surface.
      const SurfaceColumns& s = rows_.surfaces;
      const Vec ns = Get(from, s.ns_x, s.ns_y, s.ns_z), wo = Get(from, s.wo_x, s.wo_y, s.wo_z);
      const double toward = Dot(2 * Dot(ns, wo) * ns - wo, kNormal);
      if (std::fabs(toward) < 1e-5) continue;
      const double ratio = Dot(kNormal, wi) < 0 ? Ratio(material_) : 1;
      if (toward < 0) factor = 1 / (ratio * ratio);
    }
    // A cosine in floats has an error of about 2^-22.
    const SurfaceColumns& surfaces = rows_.surfaces;
    const double grazing =
        std::min(std::fabs(Dot(wi, kNormal)),
                 std::fabs(Dot(wi, Get(from, surfaces.ns_x, surfaces.ns_y, surfaces.ns_z))));
    ASSERT_NEAR(flux->throughput_r[i], radiance->throughput_r[i] * factor,
                (1e-5 + 0x1p-21 / grazing) * radiance->throughput_r[i] * factor)
        << "ray " << i;
    most = std::max(most, std::fabs(factor - 1));
  }
  EXPECT_GT(most, material_.kind == BsdfKind::kThinDielectric ? 0.1 : 0.3);
}

// The value that connections use must be the one that scattering divides by its density.
TEST_P(Flux, ConnectionsAndScatteringAgree) {
  if (rows_.kernels.delta) GTEST_SKIP();
  Bend(0.4);
  std::uint32_t n = 0;
  const auto rays = Scatter({.transport = Transport::kFlux}, &n);
  soa::Table<LightColumns> lights(kFullWave);
  soa::Table<BsdfValueColumns> values(kFullWave);
  std::vector<std::uint32_t> ray_of(kFullWave, kFullWave);
  for (std::uint32_t i = 0; i < n; ++i) {
    ray_of[rays->from[i]] = i;
    Put(RayDirection(rays, i), rays->from[i], lights->dir_x, lights->dir_y, lights->dir_z);
  }
  rows_.kernels.evaluate(rows_.surfaces, rows_.materials(), lights, kFullWave, values);
  MakeFlux(rows_.kernels, rows_.surfaces, rows_.materials(), lights, kFullWave, values);
  for (std::uint32_t row = 0; row < kFullWave; ++row) {
    const std::uint32_t i = ray_of[row];
    if (i == kFullWave) continue;
    // For mirror-like lobes, the last bits of the direction matter.
    const double drawn = double(rays->throughput_r[i]) * rays->pdf[i];
    ASSERT_NEAR(values->r[row], drawn, 0.02 * drawn + 1e-4 * rays->pdf[i]) << "row " << row;
  }
}

// The flux of light from -a scattered to b must equal the radiance of light from a seen at b: both
// ends have the same measure of light paths, f |cos| |cos| (Veach 1997, 5.3.2).
TEST_P(Flux, IsTheAdjointOfRadiance) {
  if (rows_.kernels.delta) GTEST_SKIP();
  Random random(77);
  ShadingRows same(material_, kFullWave, kNormal, kNormal);
  ShadingRows other(SeenFromBehind(material_), kFullWave, kNormal, kNormal);
  std::vector<Vec> a(kFullWave), b(kFullWave);
  std::vector<bool> through(kFullWave);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const Vec ns = Unit(kNormal + 0.4 * random.Direction());
    do a[i] = random.DirectionAbout(kNormal);
    while (Dot(a[i], ns) < 0.05 || Dot(a[i], kNormal) < 0.05);
    do b[i] = random.Direction();
    while (std::fabs(Dot(b[i], ns)) < 0.05 || Dot(b[i], ns) * Dot(b[i], kNormal) < 0);
    through[i] = Dot(b[i], kNormal) < 0;
    if (!through[i] && i % 2 == 0) {
      // This direction is near the mirror direction, where narrow lobes are.
      const Vec mirror = 2 * Dot(ns, a[i]) * ns - a[i];
      const Vec near =
          Unit(mirror + LobeWidth(material_) * random.Between(0, 2) * random.Direction());
      if (Dot(near, ns) > 0.05 && Dot(near, kNormal) > 0.05) b[i] = near;
    }
    rows_.Set(i, ns, kNormal, a[i]);
    same.Set(i, ns, kNormal, b[i]);
    other.Set(i, -ns, -kNormal, b[i]);
  }
  soa::Table<LightColumns> lights(kFullWave);
  for (std::uint32_t i = 0; i < kFullWave; ++i)
    Put(b[i], i, lights->dir_x, lights->dir_y, lights->dir_z);
  rows_.flux = true;
  auto flux = rows_.Evaluate(b);
  MakeFlux(rows_.kernels, rows_.surfaces, rows_.materials(), lights, kFullWave, flux);
  const auto back_same = same.Evaluate(a), back_other = other.Evaluate(a);
  double reflected = 0, transmitted = 0;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const double to = flux->r[i] * Dot(a[i], kNormal);
    const double from =
        (through[i] ? back_other->r[i] : back_same->r[i]) * std::fabs(Dot(b[i], kNormal));
    (through[i] ? transmitted : reflected) += to;
    const double largest = std::max(to, from);
    ASSERT_NEAR(to, from, (through[i] ? 5e-3 : 2e-3) * largest + (through[i] ? 5e-5 : 0))
        << "row " << i;
  }
  EXPECT_GT(reflected + transmitted, 0);
  EXPECT_EQ(transmitted > 0, rows_.kernels.transmits);
}

// Flux has a unit, so roulette depends only on the surface's relative attenuation.
TEST_P(Flux, RouletteIsThatOfTheSurface) {
  Bend(0.2);
  std::uint32_t n = 0, m = 0;
  const ScatterPolicy policy = {.roulette = true, .transport = Transport::kFlux};
  const auto dim = Scatter(policy, &n);
  const SurfaceColumns& s = rows_.surfaces;
  constexpr float kScale = 0x1p10f;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    s.throughput_r[i] *= kScale, s.throughput_g[i] *= kScale, s.throughput_b[i] *= kScale;
  }
  const auto bright = Scatter(policy, &m);
  ASSERT_EQ(n, m);
  for (std::uint32_t i = 0; i < n; ++i) {
    ASSERT_EQ(bright->from[i], dim->from[i]);
    ASSERT_EQ(bright->throughput_r[i], kScale * dim->throughput_r[i]);
    const float largest =
        std::max({dim->throughput_r[i], dim->throughput_g[i], dim->throughput_b[i]});
    ASSERT_GT(largest, 1 - 1e-6f);
  }
}

TEST_P(Flux, BitsDoNotDependOnTargetOrNumberOfRows) {
  Bend(0.5);
  Random random(79);
  std::vector<Vec> wi(kFullWave);
  soa::Table<LightColumns> lights(kFullWave);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    wi[i] = random.Direction();
    Put(wi[i], i, lights->dir_x, lights->dir_y, lights->dir_z);
  }
  ExpectSameOnEveryTarget([&] {
    std::uint32_t alive = 0;
    const auto rays = Scatter({.roulette = true, .transport = Transport::kFlux}, &alive);
    auto bits = ColumnBits(rays.columns(), alive);
    auto values = rows_.Evaluate(wi);
    const auto behind = ColumnBits(Slice(values.columns(), 17), kFullWave - 17);
    MakeFlux(rows_.kernels, rows_.surfaces, rows_.materials(), lights, 17, values);
    EXPECT_EQ(ColumnBits(Slice(values.columns(), 17), kFullWave - 17), behind);
    MakeFlux(rows_.kernels, Slice(rows_.surfaces.columns(), 17), rows_.materials(),
             Slice(lights.columns(), 17), kFullWave - 17, Slice(values.columns(), 17));
    const auto more = ColumnBits(values.columns(), kFullWave);
    bits.insert(bits.end(), more.begin(), more.end());
    return bits;
  });
}

// Normals that would face away from the incoming direction are turned towards it, on either side.
TEST(FaceNormals, FaceTheViewer) {
  ShadingRows rows(ExampleOf(BsdfKind::kLambert), kFullWave, kNormal, kNormal);
  Random random(83);
  std::vector<Vec> shading(kFullWave), dirs(kFullWave);
  soa::Table<LightColumns> lights(kFullWave);
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    shading[i] = Unit(kNormal + 0.9 * random.Direction());
    dirs[i] = random.Direction();
    rows.Set(i, shading[i], kNormal, kNormal);
    Put(dirs[i], i, lights->dir_x, lights->dir_y, lights->dir_z);
  }
  soa::Table<NormalColumns> normals(kFullWave);
  ExpectSameOnEveryTarget([&] {
    FaceNormals(rows.surfaces, lights, kFullWave, normals);
    return ColumnBits(normals.columns(), kFullWave);
  });
  std::uint32_t turned = 0;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const double side = Dot(kNormal, dirs[i]) < 0 ? -1 : 1;
    const double missing = 0x1p-7 - side * Dot(shading[i], dirs[i]);
    const Vec expected = Unit(shading[i] + side * std::max(missing, 0.0) * dirs[i]);
    turned += missing > 0;
    ASSERT_LT(Length(Get(i, normals->x, normals->y, normals->z) - expected), 1e-6) << "row " << i;
  }
  EXPECT_GT(turned, kFullWave / 20);
}

// Origins move to the side of the connection, and back.
TEST(MoveToSide, FollowsTheConnection) {
  for (const std::uint32_t n : kRowCounts) {
    ShadingRows rows(ExampleOf(BsdfKind::kDiffuseTransmission), kFullWave, kNormal, kNormal);
    soa::Table<LightColumns> lights(kFullWave);
    for (const double side : {-1.0, -1.0, 1.0}) {
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        Put(side * AtAngle(kNormal, 0.4), i, lights->dir_x, lights->dir_y, lights->dir_z);
      }
      MoveToSide(lights, n, rows.surfaces);
      const SurfaceColumns& s = rows.surfaces;
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        const Vec front = {double(i), 2, 3};
        const Vec expected = i < n && side < 0 ? front - 2 * 0x1p-10 * kNormal : front;
        ASSERT_LT(Length(Get(i, s.org_x, s.org_y, s.org_z) - expected), 1e-6 * (1 + Length(front)));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Flux, testing::Range(std::size_t{0}, AllCases().size()),
                         [](const testing::TestParamInfo<std::size_t>& row) {
                           return AllCases()[row.param].name;
                         });

}  // namespace
}  // namespace skywave
