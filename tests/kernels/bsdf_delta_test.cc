// Compares BSDFs without a density, their directions and throughputs, with optics in double; also
// tests what scattering does for every BSDF.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/bsdf/material.h"
#include "kernels/bsdf/pack.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/lobe_grid.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

const Vec kNormal = Unit({0.5, -0.3, -0.7});

MaterialCase Mirror(const float (&eta)[3], const float (&k)[3]) {
  MaterialRecord record = Conductor(0, eta, k);
  record.color[0] = 0.9f, record.color[1] = 0.5f, record.color[2] = 0.25f;
  return {"mirror", BsdfKind::kMirror, record};
}
MaterialCase Glass(float ior) {
  return {"glass", BsdfKind::kDielectric, {.color = {1, 0.5f, 0.25f}, .ior = ior}};
}

Vec EyeAt(double cosine) { return AtAngle(kNormal, cosine); }

TEST(Mirror, ReflectsByFresnel) {
  const float none[3] = {0, 0, 0};
  const float eta[3] = {0.143f, 0.375f, 1.442f}, k[3] = {3.983f, 2.386f, 1.603f};
  for (const MaterialCase& material : {Mirror(none, none), Mirror(eta, k)}) {
    for (const double cosine : {1.0, 0.99999, 0.9, 0.5, 0.1, 0.01}) {
      const Vec wo = EyeAt(cosine);
      const ShadingRows rows(material, 1, kNormal, wo);
      soa::Table<RayColumns> rays(1);
      ASSERT_EQ(rows.kernels.scatter(rows.surfaces, rows.materials(), ScatterRows(1, 1).view(), 1,
                                     {}, rays, 0),
                1u);
      EXPECT_LT(Angle(RayDirection(rays, 0), 2 * Dot(kNormal, wo) * kNormal - wo), 1e-6);
      EXPECT_EQ(rays->pdf[0], 0);
      const float weight[3] = {rays->throughput_r[0], rays->throughput_g[0], rays->throughput_b[0]};
      for (int c = 0; c < 3; ++c) {
        const MaterialRecord& record = material.record;
        const double exact =
            record.color[c] * FresnelReflectance(Dot(kNormal, wo), {record.eta[c], record.k[c]});
        EXPECT_NEAR(weight[c], exact, 1e-5) << "channel " << c << ", cosine " << cosine;
      }
    }
  }
}

// At cosine 1, both polarisations of Fresnel's formula are 0 / 0 for the index that represents a
// perfect mirror.
TEST(Mirror, PerfectMirrorSeenHeadOnLosesNothing) {
  MaterialRecord record = {.color = {1, 1, 1}};
  const Vec up = {0, 0, 1};
  const ShadingRows rows({"", BsdfKind::kMirror, record}, 1, up, up);
  soa::Table<RayColumns> rays(1);
  rows.kernels.scatter(rows.surfaces, rows.materials(), ScatterRows(1, 1).view(), 1, {}, rays, 0);
  EXPECT_EQ(rays->throughput_r[0], 1);
}

// What is allowed for the share of a lobe.
constexpr double kShareError = 1.01 / LobeGrid::kSize;

TEST(Glass, ReflectsAndRefractsByFresnelAndSnell) {
  for (const float ior : {1.0f, 1.1f, 1.5f, 2.4f, 0.75f}) {
    for (const bool inside : {false, true}) {
      for (const double cosine : {1.0, 0.9, 0.7, 0.5, 0.2, 0.05}) {
        const Vec wo = EyeAt(cosine);
        MaterialCase glass = Glass(ior);
        glass.back = inside;
        const LobeGrid grid(glass, kNormal, wo);
        const RayColumns& rays = grid.rays;
        // Every sample survives: light that is not reflected is refracted.
        ASSERT_EQ(grid.alive, grid.kSize);
        const double near = inside ? ior : 1, far = inside ? 1 : ior, ratio = near / far;
        const double sine_t2 = ratio * ratio * (1 - cosine * cosine);
        double reflectance = 1;
        if (sine_t2 < 1) {
          const double cos_t = std::sqrt(1 - sine_t2);
          const double s = (near * cosine - far * cos_t) / (near * cosine + far * cos_t);
          const double p = (far * cosine - near * cos_t) / (far * cosine + near * cos_t);
          reflectance = (s * s + p * p) / 2;
        }
        const Vec mirrored = 2 * cosine * kNormal - wo;
        const Vec refracted =
            (ratio * cosine - std::sqrt(std::max(0.0, 1 - sine_t2))) * kNormal - ratio * wo;
        for (std::uint32_t i = 0; i < grid.kSize; ++i) {
          const Vec origin = Get(i, rays.org_x, rays.org_y, rays.org_z);
          const SurfaceColumns& s = grid.rows.surfaces;
          const Vec front = Get(i, s.org_x, s.org_y, s.org_z);
          const bool reflects = grid.Reflects(i);
          ASSERT_EQ(rays.pdf[i], 0);
          ASSERT_LT(Angle(grid.Direction(i), reflects ? mirrored : refracted),
                    3e-6 / std::sqrt(cosine));
          // Refraction preserves radiance over the squared index.
          const double weight = reflects ? 1 : ratio * ratio;
          ASSERT_NEAR(rays.throughput_r[i], weight, 1e-6 * weight);
          ASSERT_NEAR(rays.throughput_b[i], weight / 4, 1e-6 * weight);
          // The ray leaves on its own side, at the same distance from the surface as on the other.
          const Vec expected = reflects ? front : front - 2 * 0x1p-10 * kNormal;
          ASSERT_LT(Length(origin - expected), 1e-6 * (1 + Length(front)));
        }
        EXPECT_NEAR(grid.ReflectedShare(), reflectance, kShareError + 2e-5)
            << "index " << ior << (inside ? " from inside" : "") << ", cosine " << cosine;
        EXPECT_TRUE(sine_t2 < 1 || grid.ReflectedShare() == 1) << "total internal reflection";
      }
    }
  }
}

// Both faces are handled at once: 2 R / (1 + R) is reflected, the rest continues straight and
// unscaled.
TEST(ThinGlass, ReflectsTwiceAndBendsNothing) {
  MaterialCase pane = Glass(1.5f);
  pane.kind = BsdfKind::kThinDielectric;
  for (const bool back : {false, true}) {
    pane.back = back;
    for (const double cosine : {1.0, 0.7, 0.2, 0.05}) {
      const Vec wo = EyeAt(cosine);
      const LobeGrid grid(pane, kNormal, wo);
      ASSERT_EQ(grid.alive, grid.kSize);
      const double once = FresnelReflectance(cosine, 1.5);
      for (std::uint32_t i = 0; i < grid.kSize; ++i) {
        ASSERT_EQ(grid.rays->pdf[i], 0);
        ASSERT_LT(Angle(grid.Direction(i), grid.Reflects(i) ? 2 * cosine * kNormal - wo : -wo),
                  3e-6 / std::sqrt(cosine));
        ASSERT_NEAR(grid.Throughput(i).r, 1, 1e-6);
        ASSERT_NEAR(grid.Throughput(i).b, 0.25, 1e-6);
      }
      EXPECT_NEAR(grid.ReflectedShare(), 2 * once / (1 + once), kShareError + 2e-5);
    }
  }
}

// A black pane that reflects white reflects once, at its surface, as KHR_materials_transmission has
// it: 4 % of light from above, at index 1.5.
TEST(ThinGlass, ReflectsOnceWithAColourOfItsOwn) {
  MaterialCase pane = {"pane", BsdfKind::kThinDielectric, {.eta = {1, 0.5f, 0.25f}, .ior = 1.5f}};
  for (const double cosine : {1.0, 0.2}) {
    const LobeGrid grid(pane, kNormal, EyeAt(cosine));
    const double once = FresnelReflectance(cosine, 1.5);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(grid.Reflected()[c], once / (1 << c), kShareError);
      EXPECT_EQ(grid.Transmitted()[c], 0);
    }
  }
}

// What is reflected has the colour that the material gives it, also black, and what passes that of
// the reflectance.
TEST(Glass, ReflectionsHaveAColourOfTheirOwn) {
  for (const BsdfKind kind : {BsdfKind::kDielectric, BsdfKind::kThinDielectric}) {
    for (const glm::vec3 reflection : {glm::vec3(0, 0.5f, 1), glm::vec3(0.75f, 0, 0)}) {
      const Material glass = {
          .bsdf = kind, .reflectance = {1, 0.5f, 0.25f}, .reflection = reflection};
      const LobeGrid grid({"glass", kind, PackMaterial(glass, {})}, kNormal, EyeAt(0.2));
      for (std::uint32_t i = 0; i < grid.alive; ++i) {
        const double squared = kind == BsdfKind::kDielectric ? 1 / (1.5 * 1.5) : 1;
        const glm::dvec3 exact =
            grid.Reflects(i) ? glm::dvec3(reflection) : squared * glm::dvec3(glass.reflectance);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(grid.Throughput(i)[c], exact[c], 1e-6);
      }
      EXPECT_GT(grid.ReflectedShare(), 0.25);
      EXPECT_GT(double(grid.alive) / grid.kSize - grid.ReflectedShare(), 0.25);
    }
  }
}

// If a shading normal would reflect below the surface, the geometric normal is used instead.
TEST(Mirror, BentNormalsKeepTheReflectionAbove) {
  constexpr std::uint32_t kRows = 2000;
  const float none[3] = {0, 0, 0};
  for (const MaterialCase& material : {Mirror(none, none), Glass(1.5f)}) {
    ShadingRows rows(material, kRows, kNormal, kNormal);
    Random random(5);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const Vec ng = random.Direction(), ns = Unit(ng + 0.6 * random.Direction());
      Vec wo = random.DirectionAbout(ng);
      if (Dot(wo, ns) < 0.02) wo = Unit(ng + ns);
      rows.Set(i, ns, ng, wo);
    }
    ScatterRows uniforms(kRows, 6);
    std::fill_n(uniforms.lobe->u, kRows, 0.0f);  // glass reflects
    soa::Table<RayColumns> rays(kRows);
    ASSERT_EQ(
        rows.kernels.scatter(rows.surfaces, rows.materials(), uniforms.view(), kRows, {}, rays, 0),
        kRows);
    const SurfaceColumns& s = rows.surfaces;
    for (std::uint32_t i = 0; i < kRows; ++i) {
      ASSERT_GT(Dot(RayDirection(rays, i), Get(i, s.ng_x, s.ng_y, s.ng_z)), 0) << "row " << i;
    }
  }
}

TEST(Bsdfs, DeltaBsdfsComeAfterTheOthers) {
  const auto table = Bsdfs();
  for (std::uint32_t k = 0; k < kBsdfKinds; ++k) {
    EXPECT_EQ(table[k].delta, k >= kFirstDeltaBsdf) << table[k].name;
    EXPECT_EQ(table[k].evaluate_lights == nullptr, table[k].delta) << table[k].name;
  }
}

class AnyBsdf : public testing::TestWithParam<std::uint32_t> {
 protected:
  AnyBsdf() : rows_(Material(), kFullWave, kNormal, kNormal) {
    Random random(51);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const Vec ng = random.Direction(), ns = Unit(ng + 0.3 * random.Direction());
      Vec wo = random.DirectionAbout(ng);
      if (Dot(wo, ns) < 0.02) wo = Unit(ng + ns);
      rows_.Set(i, ns, ng, wo);
      const SurfaceColumns& s = rows_.surfaces;
      s.throughput_r[i] = float(random.Between(0, 1)), s.throughput_g[i] = 0.1f;
      s.throughput_b[i] = i % 3 == 0 ? 0.0f : 0.4f;
      if (i % 13 == 0) s.throughput_r[i] = s.throughput_g[i] = s.throughput_b[i] = 0;
      if (i % 2 == 0) s.material[i] |= kBackFace;
    }
  }
  static MaterialCase Material() { return ExampleOf(BsdfKind(GetParam())); }
  std::uint32_t Scatter(const ScatterRows& uniforms, std::uint32_t n, const ScatterPolicy& policy,
                        const RayColumns& rays, std::uint32_t appended) const {
    return rows_.kernels.scatter(rows_.surfaces, rows_.materials(), uniforms.view(), n, policy,
                                 rays, appended);
  }
  ShadingRows rows_;
};

TEST_P(AnyBsdf, DeltaValuesAreZero) {
  if (!rows_.kernels.delta) GTEST_SKIP();
  const auto values = rows_.Evaluate(std::vector<Vec>(kFullWave, kNormal));
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    ASSERT_EQ(values->pdf[i] + values->r[i] + values->g[i] + values->b[i], 0);
  }
}

// Rays are appended in the order of their surfaces, after the existing ones.
TEST_P(AnyBsdf, AppendsRaysInOrder) {
  const ScatterRows uniforms(kFullWave, 53);
  soa::Table<RayColumns> all(kFullWave);
  const std::uint32_t alive = Scatter(uniforms, kFullWave, {}, all, 0);
  ASSERT_GT(alive, kFullWave / 2);
  for (std::uint32_t i = 0; i < alive; ++i) {
    const std::uint32_t from = all->from[i];
    ASSERT_TRUE(i == 0 || from > all->from[i - 1]) << "row " << i;
    ASSERT_EQ(all->path[i], 7 * from + 1);
    ASSERT_EQ(all->t_far[i], std::numeric_limits<float>::infinity());
    ASSERT_NE(from % 13, 0u) << "a path without throughput goes on";
    ASSERT_NEAR(Length(RayDirection(all, i)), 1, 1e-5);
  }
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      constexpr std::uint32_t kBefore = 5, kFirstRow = 100;
      soa::Table<RayColumns> rays(kFullWave + kBefore);
      FillWithGarbage(rays.columns(), kFullWave + kBefore);
      const auto before = ColumnBits(rays.columns(), kBefore);
      const std::uint32_t end = Scatter(uniforms, n, {.first_row = kFirstRow}, rays, kBefore);
      const auto expected =
          std::uint32_t(std::lower_bound(all->from, all->from + alive, n) - all->from);
      ASSERT_EQ(end, kBefore + expected) << n << " rows";
      EXPECT_EQ(ColumnBits(rays.columns(), kBefore), before);
      for (std::uint32_t i = 0; i < expected; ++i) rays->from[kBefore + i] -= kFirstRow;
      EXPECT_EQ(ColumnBits(Slice(rays.columns(), kBefore), expected),
                ColumnBits(all.columns(), expected))
          << n << " rows";
    }
  });
}

// A path survives with probability min(1, largest throughput), and the survivors compensate for the
// others.
TEST_P(AnyBsdf, RouletteKeepsTheMean) {
  constexpr std::uint32_t kGrid = 1024;
  ScatterRows uniforms(kFullWave, 55);
  soa::Table<RayColumns> all(kFullWave), some(kFullWave);
  const std::uint32_t alive = Scatter(uniforms, kFullWave, {}, all, 0);
  std::vector<std::uint32_t> survivals(kFullWave);
  for (std::uint32_t step = 0; step < kGrid; ++step) {
    std::fill_n(uniforms.lobe->v, kFullWave, (float(step) + 0.5f) / kGrid);
    const std::uint32_t left = Scatter(uniforms, kFullWave, {.roulette = true}, some, 0);
    std::uint32_t at = 0;
    for (std::uint32_t i = 0; i < left; ++i) {
      ++survivals[some->from[i]];
      if (step % 64 != 0) continue;
      while (all->from[at] != some->from[i]) ++at;
      const double largest =
          std::max({all->throughput_r[at], all->throughput_g[at], all->throughput_b[at]});
      const double share = std::min(1.0, largest);
      ASSERT_NEAR(some->throughput_r[i] * share, all->throughput_r[at], 1e-6);
      ASSERT_NEAR(some->throughput_b[i] * share, all->throughput_b[at], 1e-6);
    }
  }
  for (std::uint32_t i = 0; i < alive; ++i) {
    const double largest =
        std::max({all->throughput_r[i], all->throughput_g[i], all->throughput_b[i]});
    ASSERT_NEAR(survivals[all->from[i]] / double(kGrid), std::min(1.0, largest), 1.01 / kGrid);
  }
}

TEST_P(AnyBsdf, BitsDoNotDependOnTarget) {
  const ScatterRows uniforms(kFullWave, 57);
  ExpectSameOnEveryTarget([&] {
    soa::Table<RayColumns> rays(kFullWave);
    const std::uint32_t alive = Scatter(uniforms, kFullWave, {.roulette = true}, rays, 0);
    return ColumnBits(rays.columns(), alive);
  });
}

INSTANTIATE_TEST_SUITE_P(All, AnyBsdf, testing::Range(0u, kBsdfKinds),
                         [](const testing::TestParamInfo<std::uint32_t>& kind) {
                           std::string name(Bsdfs()[kind.param].name);
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace skywave
