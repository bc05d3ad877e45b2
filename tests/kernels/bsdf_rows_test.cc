// Tests the loops over rows for every BSDF with a density.

#include "kernels/bsdf/bsdf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/bsdf_cases.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

const std::vector<MaterialCase>& Materials() { return DenseCases(); }

class DenseBsdfRows : public testing::TestWithParam<std::size_t> {
 protected:
  // Creates random surfaces, half of them with a bent shading normal, and random light samples.
  DenseBsdfRows()
      : rows_(material_, kFullWave, {0, 0, 1}, {0, 0, 1}), lights_(kFullWave), wi_(kFullWave) {
    Random random(41);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const Vec ng = random.Direction();
      const Vec ns = i % 2 == 0 ? ng : Unit(ng + 0.4 * random.Direction());
      Vec wo = random.DirectionAbout(ng);
      if (Dot(wo, ns) <= 0.01) wo = ns;
      rows_.Set(i, ns, ng, wo);
      const SurfaceColumns& s = rows_.surfaces;
      s.throughput_r[i] = float(random.Between(0, 2)), s.throughput_g[i] = 0.5f;
      s.throughput_b[i] = i % 5 == 0 ? 0.0f : 1.0f;
      wi_[i] = random.Direction();
      Put(wi_[i], i, lights_->dir_x, lights_->dir_y, lights_->dir_z);
      lights_->r[i] = float(random.Between(0, 10)), lights_->g[i] = 1, lights_->b[i] = 3;
      if (i % 7 == 0) lights_->r[i] = lights_->g[i] = lights_->b[i] = 0;
      lights_->pdf[i] = i % 11 == 0 ? 0.0f : float(random.Between(0.01, 5));
    }
  }
  soa::Table<LightColumns> CopyOfLights() const {
    soa::Table<LightColumns> copy(kFullWave);
    const LightColumns& from = lights_;
    std::copy_n(from.dir_x, kFullWave, copy->dir_x),
        std::copy_n(from.dir_y, kFullWave, copy->dir_y);
    std::copy_n(from.dir_z, kFullWave, copy->dir_z), std::copy_n(from.pdf, kFullWave, copy->pdf);
    std::copy_n(from.r, kFullWave, copy->r), std::copy_n(from.g, kFullWave, copy->g);
    std::copy_n(from.b, kFullWave, copy->b), std::fill_n(copy->t_far, kFullWave, 42.0f);
    return copy;
  }
  const MaterialCase& material_ = Materials()[GetParam()];
  ShadingRows rows_;
  soa::Table<LightColumns> lights_;
  std::vector<Vec> wi_;
};

TEST_P(DenseBsdfRows, NothingIsReflectedThroughTheSurface) {
  const auto values = rows_.Evaluate(wi_);
  const SurfaceColumns& s = rows_.surfaces;
  std::uint32_t below = 0;
  // Powers and exponentials underflow to zero, and refracting facets do not exist for every
  // direction.
  const bool ends = material_.kind >= BsdfKind::kDiffuseTransmission;
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    const double g = Dot(Get(i, s.ng_x, s.ng_y, s.ng_z), wi_[i]);
    const double h = Dot(Get(i, s.ns_x, s.ns_y, s.ns_z), wi_[i]);
    const bool through = g < -1e-6 && h < -1e-6 && TransmissionRatio(material_);
    if (!through && (g < -1e-6 || h < -1e-6)) {
      ++below;
      ASSERT_EQ(values->pdf[i], 0);
      ASSERT_EQ(values->r[i] + values->g[i] + values->b[i], 0);
    } else if (g > 1e-6 && h > 1e-6 && !ends) {
      ASSERT_GT(values->pdf[i], 0);
    }
  }
  // For transmissive surfaces, only the wedge between the two normals remains.
  EXPECT_GT(below, TransmissionRatio(material_) ? kFullWave / 64 : kFullWave / 3);
  soa::Table<RayColumns> rays(kFullWave);
  const ScatterRows uniforms(kFullWave, 43);
  const std::uint32_t alive = rows_.kernels.scatter(rows_.surfaces, rows_.materials(),
                                                    uniforms.view(), kFullWave, {}, rays, 0);
  EXPECT_GT(alive, kFullWave / 2);
  for (std::uint32_t i = 0; i < alive; ++i) {
    const std::uint32_t from = rays->from[i];
    const Vec wi = RayDirection(rays, i);
    const double g = Dot(Get(from, s.ng_x, s.ng_y, s.ng_z), wi);
    const double h = Dot(Get(from, s.ns_x, s.ns_y, s.ns_z), wi);
    ASSERT_GT(g * h, -1e-6);
    ASSERT_TRUE(g > -1e-6 || TransmissionRatio(material_));
    // The ray leaves on the side to which it goes.
    const Vec front = {double(from), 2, 3};
    const Vec ng = Get(from, s.ng_x, s.ng_y, s.ng_z);
    const Vec origin = Get(i, rays->org_x, rays->org_y, rays->org_z);
    const Vec expected = g > 0 ? front : front - 2 * 0x1p-10 * ng;
    ASSERT_LT(Length(origin - expected), 1e-6 * (1 + Length(front)));
  }
}

// Shadow rays start on the side of their light, even if the side changes repeatedly, and scattering
// accounts for it.
TEST_P(DenseBsdfRows, OriginsFollowTheLight) {
  const SurfaceColumns& s = rows_.surfaces;
  for (int sample = 0; sample < 3; ++sample) {
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      if (sample == 1) Put(-wi_[i], i, lights_->dir_x, lights_->dir_y, lights_->dir_z);
      if (sample == 2) Put(wi_[i], i, lights_->dir_x, lights_->dir_y, lights_->dir_z);
    }
    const auto lights = CopyOfLights();
    rows_.kernels.evaluate_lights(rows_.surfaces, rows_.materials(), kFullWave, {}, lights);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      if (lights->t_far[i] < 0) continue;
      const Vec ng = Get(i, s.ng_x, s.ng_y, s.ng_z);
      const bool behind = Dot(ng, sample == 1 ? -wi_[i] : wi_[i]) < 0;
      ASSERT_FALSE(behind && !TransmissionRatio(material_));
      const Vec front = {double(i), 2, 3};
      const Vec expected = behind ? front - 2 * 0x1p-10 * ng : front;
      const Vec origin = Get(i, s.org_x, s.org_y, s.org_z);
      ASSERT_LT(Length(origin - expected), 1e-6 * (1 + Length(front))) << "row " << i;
    }
  }
  soa::Table<RayColumns> rays(kFullWave);
  const ScatterRows uniforms(kFullWave, 47);
  const std::uint32_t alive = rows_.kernels.scatter(rows_.surfaces, rows_.materials(),
                                                    uniforms.view(), kFullWave, {}, rays, 0);
  for (std::uint32_t i = 0; i < alive; ++i) {
    const std::uint32_t from = rays->from[i];
    const Vec ng = Get(from, s.ng_x, s.ng_y, s.ng_z), front = {double(from), 2, 3};
    const Vec expected = Dot(ng, RayDirection(rays, i)) > 0 ? front : front - 2 * 0x1p-10 * ng;
    ASSERT_LT(Length(Get(i, rays->org_x, rays->org_y, rays->org_z) - expected),
              1e-6 * (1 + Length(front)));
  }
}

TEST_P(DenseBsdfRows, LightSamplesAreWeighted) {
  const auto values = rows_.Evaluate(wi_);
  const SurfaceColumns& s = rows_.surfaces;
  // A directional light is a sample of infinite density: it counts in full, with or without MIS.
  for (const bool directional : {false, true}) {
    for (const bool enabled : {true, false}) {
      const auto lights = CopyOfLights();
      if (directional) {
        std::fill_n(lights->pdf, kFullWave, std::numeric_limits<float>::infinity());
      }
      rows_.kernels.evaluate_lights(rows_.surfaces, rows_.materials(), kFullWave,
                                    {.enabled = enabled}, lights);
      std::uint32_t open = 0;
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        const double p = lights_->pdf[i], q = values->pdf[i];
        const double factor = directional ? 1 : p <= 0 ? 0 : enabled ? p / (p * p + q * q) : 1 / p;
        const double exact[3] = {factor * s.throughput_r[i] * values->r[i] * lights_->r[i],
                                 factor * s.throughput_g[i] * values->g[i] * lights_->g[i],
                                 factor * s.throughput_b[i] * values->b[i] * lights_->b[i]};
        const float gain[3] = {lights->r[i], lights->g[i], lights->b[i]};
        for (int c = 0; c < 3; ++c) {
          // The tolerance covers eight roundings of 2^-24; tiny values underflow to 0.
          ASSERT_NEAR(gain[c], exact[c], 5e-7 * exact[c] + 1e-30) << "row " << i;
        }
        const bool counts = exact[0] + exact[1] + exact[2] > 1e-30;
        open += counts;
        if (counts) {
          ASSERT_EQ(lights->t_far[i], std::numeric_limits<float>::infinity());
        } else if (exact[0] + exact[1] + exact[2] == 0) {
          ASSERT_LT(lights->t_far[i], 0);
        }
        // The ray itself remains unchanged.
        ASSERT_EQ(lights->dir_x[i], lights_->dir_x[i]);
      }
      EXPECT_GT(open, LobeWidth(material_) > 0.05 ? 100u : 10u);
    }
  }
}

TEST_P(DenseBsdfRows, RowsAfterASliceAreLeftAlone) {
  const auto full = CopyOfLights();
  rows_.kernels.evaluate_lights(rows_.surfaces, rows_.materials(), kFullWave, {}, full);
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      const auto lights = CopyOfLights(), untouched = CopyOfLights();
      rows_.kernels.evaluate_lights(rows_.surfaces, rows_.materials(), n, {}, lights);
      EXPECT_EQ(ColumnBits(lights.columns(), n), ColumnBits(full.columns(), n)) << n << " rows";
      EXPECT_EQ(ColumnBits(Slice(lights.columns(), n), kFullWave - n),
                ColumnBits(Slice(untouched.columns(), n), kFullWave - n))
          << n << " rows";
    }
  });
}

TEST_P(DenseBsdfRows, BitsDoNotDependOnTargetOrNumberOfRows) {
  const ScatterRows uniforms(kFullWave, 45);
  ExpectSameOnEveryTarget([&] {
    std::vector<std::uint32_t> bits;
    const auto append = [&](const auto& columns, std::uint32_t n) {
      const auto more = ColumnBits(columns, n);
      bits.insert(bits.end(), more.begin(), more.end());
    };
    for (const bool mis : {true, false}) {
      const auto lights = CopyOfLights();
      rows_.kernels.evaluate_lights(rows_.surfaces, rows_.materials(), kFullWave, {.enabled = mis},
                                    lights);
      append(lights.columns(), kFullWave);
    }
    append(rows_.Evaluate(wi_).columns(), kFullWave);
    for (const bool roulette : {false, true}) {
      soa::Table<RayColumns> rays(kFullWave);
      const std::uint32_t alive =
          rows_.kernels.scatter(rows_.surfaces, rows_.materials(), uniforms.view(), kFullWave,
                                {.roulette = roulette}, rays, 0);
      bits.push_back(alive);
      append(rays.columns(), alive);
    }
    return bits;
  });
}

INSTANTIATE_TEST_SUITE_P(All, DenseBsdfRows, testing::Range(std::size_t{0}, DenseCases().size()),
                         [](const testing::TestParamInfo<std::size_t>& row) {
                           return Materials()[row.param].name;
                         });

}  // namespace
}  // namespace skywave
