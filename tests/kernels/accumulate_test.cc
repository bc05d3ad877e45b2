// Tests accumulation: the two halves of multiple importance sampling add up to the whole, and every
// path receives its own light.

#include "kernels/accumulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/shading_rows.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Each direction is evaluated once as a light sample and once as a BSDF sample.
TEST(Accumulate, WeightsOfLightAndBsdfSamplesSumToOne) {
  constexpr std::uint32_t kRows = 1000;
  const Vec normal = Unit({0.2, -0.6, 0.7});
  const std::vector<MaterialCase> materials = {
      {"lambert", BsdfKind::kLambert, {.color = {0.7f, 0.5f, 0.9f}}},
      {"gold", BsdfKind::kConductor, GoldConductor(0.2f)}};
  for (const MaterialCase& material : materials) {
    for (const float light_samples : {1.0f, 3.0f, 16.0f}) {
      const MisPolicy mis = {.enabled = true};
      ShadingRows rows(material, kRows, normal, AtAngle(normal, 0.6));
      Random random(101);
      std::vector<Vec> wi(kRows);
      soa::Table<LightColumns> lights(kRows);
      for (std::uint32_t i = 0; i < kRows; ++i) {
        wi[i] = random.DirectionAbout(normal);
        Put(wi[i], i, lights->dir_x, lights->dir_y, lights->dir_z);
        // Densities include the number of samples.
        lights->pdf[i] = light_samples * float(std::pow(10, random.Between(-3, 3)));
        lights->r[i] = lights->g[i] = lights->b[i] = 2;
      }
      const auto values = rows.Evaluate(wi);
      soa::Table<EscapeColumns> escaped(kRows);
      soa::Table<PathColumns> paths(kRows);
      for (std::uint32_t i = 0; i < kRows; ++i) {
        escaped->pdf[i] = values->pdf[i];
        escaped->light_pdf[i] = lights->pdf[i];
        escaped->throughput_r[i] = values->r[i] / values->pdf[i];
        escaped->radiance_r[i] = 2;
        escaped->path[i] = i;
      }
      std::vector<float> light_pdf(lights->pdf, lights->pdf + kRows);
      rows.kernels.evaluate_lights(rows.surfaces, rows.materials(), kRows, mis, lights);
      AddEscapedRadiance(escaped, kRows, mis, paths);
      for (std::uint32_t i = 0; i < kRows; ++i) {
        if (Dot(wi[i], normal) < 1e-3) continue;
        // Both weights are the result divided by what it would be unweighted.
        const double integrand = 2.0 * values->r[i];
        const double light_weight = lights->r[i] * light_pdf[i] / integrand;
        const double bsdf_weight = paths->r[i] * values->pdf[i] / integrand;
        ASSERT_NEAR(light_weight + bsdf_weight, 1, 1e-5) << material.name << " row " << i;
        ASSERT_GE(light_weight, 0);
        ASSERT_GE(bsdf_weight, 0);
        const double p = light_pdf[i], q = values->pdf[i];
        ASSERT_NEAR(bsdf_weight, q * q / (p * p + q * q), 1e-5) << "power heuristic";
      }
    }
  }
}

class AccumulateRows : public testing::Test {
 protected:
  AccumulateRows() : escaped_(kFullWave), lights_(kFullWave), to_(PaddedRows(kFullWave)) {
    Random random(102);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      escaped_->throughput_r[i] = 1, escaped_->throughput_g[i] = random.Float();
      escaped_->throughput_b[i] = 0;
      escaped_->radiance_r[i] = float(i), escaped_->radiance_g[i] = 2;
      escaped_->radiance_b[i] = 1e6f;
      // Rows without a density receive all of the light, whatever light_pdf holds.
      escaped_->pdf[i] = i % 3 == 0 ? 0.0f : float(random.Between(0.01, 10));
      escaped_->light_pdf[i] = i % 3 == 0   ? std::numeric_limits<float>::quiet_NaN()
                               : i % 5 == 0 ? 0.0f
                                            : float(random.Between(0.01, 10));
      // Every path occurs once, in a scattered order.
      to_[i] = escaped_->path[i] = (i * 517u) % kFullWave;
      lights_->r[i] = 1, lights_->g[i] = float(i), lights_->b[i] = 0.5f;
      lights_->t_far[i] = i % 4 == 0 ? kInfinity : i % 4 == 1 ? -kInfinity : i % 4 == 2 ? -1 : 0;
    }
  }
  static soa::Table<PathColumns> Started() {
    soa::Table<PathColumns> paths(kFullWave);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      paths->r[i] = float(i), paths->g[i] = 1, paths->b[i] = 0.25f;
    }
    return paths;
  }
  soa::Table<EscapeColumns> escaped_;
  soa::Table<LightColumns> lights_;
  std::vector<std::uint32_t> to_;
};

TEST_F(AccumulateRows, EscapedRadianceGoesToItsPath) {
  ForEachTarget([&] {
    for (const bool enabled : {true, false}) {
      for (const std::uint32_t n : kRowCounts) {
        const auto paths = Started(), before = Started();
        AddEscapedRadiance(escaped_, n, {.enabled = enabled}, paths);
        std::vector<double> r(kFullWave), g(kFullWave);
        for (std::uint32_t i = 0; i < n; ++i) {
          const double p = escaped_->pdf[i], l = escaped_->light_pdf[i];
          const double weight = p == 0 ? 1 : enabled ? p * p / (p * p + l * l) : 0;
          r[to_[i]] = weight * escaped_->radiance_r[i];
          g[to_[i]] = weight * 2 * escaped_->throughput_g[i];
        }
        for (std::uint32_t i = 0; i < kFullWave; ++i) {
          ASSERT_NEAR(paths->r[i], before->r[i] + r[i], 1e-6 * (1 + before->r[i] + r[i])) << i;
          ASSERT_NEAR(paths->g[i], before->g[i] + g[i], 1e-6) << i;
          ASSERT_EQ(paths->b[i], before->b[i]) << i;
        }
      }
    }
  });
}

TEST_F(AccumulateRows, OnlyUnoccludedLightArrives) {
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      const auto paths = Started();
      AddUnoccludedRadiance(lights_, to_.data(), n, paths);
      const auto expected = Started();
      for (std::uint32_t i = 0; i < n; ++i) {
        if (i % 4 == 1 || i % 4 == 2) continue;
        expected->r[to_[i]] += 1, expected->g[to_[i]] += float(i), expected->b[to_[i]] += 0.5f;
      }
      EXPECT_EQ(ColumnBits(paths.columns(), kFullWave), ColumnBits(expected.columns(), kFullWave))
          << n << " rows";
    }
  });
}

// The value of an occluded row may be arbitrary.
TEST_F(AccumulateRows, OccludedRowsMayBeNan) {
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    if (lights_->t_far[i] < 0) lights_->r[i] = std::numeric_limits<float>::quiet_NaN();
  }
  ForEachTarget([&] {
    const auto paths = Started();
    AddUnoccludedRadiance(lights_, to_.data(), kFullWave, paths);
    for (std::uint32_t i = 0; i < kFullWave; ++i) ASSERT_TRUE(std::isfinite(paths->r[i])) << i;
  });
}

}  // namespace
}  // namespace skywave
