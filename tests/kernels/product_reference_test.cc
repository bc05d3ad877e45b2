// Compares the kernels that weigh cells and candidates with scalar double arithmetic, row by row.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/bsdf/product.h"
#include "kernels/bsdf/resampling.h"
#include "kernels/lights/directional.h"
#include "kernels/lights/texel_samplers.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/cell_sampler.h"
#include "lights/tables/texels.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/shade_points.h"
#include "tests/support/shading_rows.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr std::uint32_t kRows = 3000;
constexpr float kSamples = 3;  // densities include this number of samples

TEST(SamplingReference, CellsArePickedByTheirSums) {
  constexpr std::uint32_t kCount = 37;
  Random random(10);
  std::vector<float> sums(kCount * kProductStride);
  for (std::uint32_t i = 0; i < kProductRows; ++i) {
    float sum = 0;
    for (std::uint32_t k = 0; k < kCount; ++k) {
      if (i != 5 && (k + i) % 3 != 0) sum += random.Float();  // row 5 has no weight
      sums[k * kProductStride + i] = sum;
    }
  }
  const auto uniforms = RandomUniforms(kProductRows, 11);
  uniforms->u[7] = 0, uniforms->u[8] = 0x1.fffffep-1f;
  ForEachTarget([&] {
    CellPicks picks;
    float norm[kProductStride];
    PickCells(sums.data(), kCount, uniforms->u, kProductRows, picks, norm);
    for (std::uint32_t i = 0; i < kProductRows; ++i) {
      const auto sum = [&](int k) { return k < 0 ? 0.0 : double(sums[k * kProductStride + i]); };
      const double total = sum(kCount - 1);
      ASSERT_EQ(norm[i], float(total));
      if (total == 0) {
        ASSERT_EQ(picks.probability[i], 0) << "row " << i;
        continue;
      }
      int cell = 0;
      while (sum(cell) <= uniforms->u[i] * total) ++cell;
      const double weight = sum(cell) - sum(cell - 1);
      ASSERT_EQ(picks.cell[i], std::uint32_t(cell)) << "row " << i;
      ASSERT_NEAR(picks.probability[i], weight / total, 1e-6);
      ASSERT_NEAR(picks.x[i], (uniforms->u[i] * total - sum(cell - 1)) / weight, 1e-4);
      ASSERT_LT(picks.x[i], 1);
    }
  });
}

// Returns the weight defined in kernels/bsdf/bsdf.h, in double.
double CellWeight(const MaterialCase& material, const LightCell& cell, Vec normal, Vec wo) {
  const Vec wi = {cell.dir[0], cell.dir[1], cell.dir[2]};
  const double height = Dot(normal, wi);
  const float* color = material.record.color;
  const double luminance = 0.2125 * color[0] + 0.7154 * color[1] + 0.0721 * color[2];
  double value = luminance * height / kPi;
  if (material.kind == BsdfKind::kConductor) {
    const Vec h = Unit(wo + wi);
    const double hz = Dot(h, normal), alpha = material.record.alpha;
    const double a2 = alpha * alpha + 0.25 * cell.radius * cell.radius;
    const double d = a2 / (kPi * std::pow(a2 * hz * hz + 1 - hz * hz, 2));
    const double g =
        std::min(1.0, 2 * hz * std::min(Dot(normal, wo), height) / std::max(1e-6, Dot(wo, h)));
    value = luminance * d * g / (4 * Dot(normal, wo));
  }
  value = std::max(height > 0 ? value : 0, 0.05 / kPi * std::max(luminance, 0.04));
  const double above = std::clamp(1 + height / cell.reach, 0.0, 1.0);
  return value * cell.energy * above * above;
}

TEST(SamplingReference, CellsAreWeighedByLightAndBsdf) {
  Random random(12);
  std::vector<LightCell> cells;
  for (int k = 0; k < 30; ++k) {
    const Vec d = random.Direction();
    cells.push_back({.dir = {float(d.x), float(d.y), float(d.z)},
                     .energy = random.Float(),
                     .radius = 0.3f * random.Float(),
                     .reach = 0.01f + 0.6f * random.Float()});
  }
  constexpr std::uint32_t n = 50;
  for (const MaterialCase& material :
       {MaterialCase{"Lambert", BsdfKind::kLambert, {.color = {0.2f, 0.5f, 0.8f}}},
        MaterialCase{"Gold", BsdfKind::kConductor, GoldConductor(0.2f)}}) {
    ShadingRows rows(material, n, {0, 0, 1}, {0, 0, 1});
    std::vector<Vec> normals(n), wos(n);
    std::vector<std::uint32_t> picked(PaddedRows(n));
    for (std::uint32_t i = 0; i < n; ++i) {
      normals[i] = random.Direction();
      wos[i] = AtAngle(normals[i], random.Between(0.1, 0.99));
      rows.Set(i, normals[i], normals[i], wos[i]);
      picked[i] = random.Word() % 30;
    }
    ForEachTarget([&] {
      std::vector<float> sums(30 * kProductStride), weight(PaddedRows(n));
      rows.kernels.weigh_cells(rows.surfaces, rows.materials(), n, cells.data(), 30, sums.data(),
                               kProductStride);
      rows.kernels.weigh_cell(rows.surfaces, rows.materials(), n, cells.data(), picked.data(),
                              weight.data());
      for (std::uint32_t i = 0; i < n; ++i) {
        double sum = 0;
        for (std::uint32_t k = 0; k < 30; ++k) {
          const double exact = CellWeight(material, cells[k], normals[i], wos[i]);
          sum += exact;
          ASSERT_NEAR(sums[k * kProductStride + i], sum, 2e-4 * sum + 1e-6)
              << material.name << ", row " << i << ", cell " << k;
          if (k == picked[i]) {
            ASSERT_NEAR(weight[i], exact, 2e-4 * exact + 1e-6) << material.name << ", row " << i;
          }
        }
      }
    });
  }
}

TEST(SamplingReference, Reservoirs) {
  constexpr CandidateCounts kCounts = {.map = 3, .bsdf = 2};
  constexpr int kCandidates = 5;
  const auto uniforms = RandomUniforms(kRows, 14);
  struct Reservoir {
    double sum = 0, target = 0, x;
    int kept = -1;
  };
  ForEachTarget([&] {
    Random random(15);
    soa::Table<ReservoirColumns> reservoirs(kRows);
    StartReservoirs(uniforms->u, kRows, reservoirs);
    std::vector<Reservoir> exact(kRows);
    for (std::uint32_t i = 0; i < kRows; ++i) exact[i].x = uniforms->u[i];
    std::vector<soa::Table<LightColumns>> candidates;
    for (int k = 0; k < kCandidates; ++k) {
      candidates.emplace_back(kRows);
      const LightColumns& lights = candidates.back();
      soa::Table<BsdfValueColumns> values(kRows);
      for (std::uint32_t i = 0; i < kRows; ++i) {
        Put(random.Direction(), i, lights.dir_x, lights.dir_y, lights.dir_z);
        lights.r[i] = random.Float(), lights.g[i] = random.Float(), lights.b[i] = random.Float();
        lights.pdf[i] = random.Float();
        values->r[i] = values->g[i] = values->b[i] = (i + k) % 4 == 0 ? 0 : random.Float();
        values->pdf[i] = random.Float();
        const double target =
            values->r[i] * (0.2125 * lights.r[i] + 0.7154 * lights.g[i] + 0.0721 * lights.b[i]);
        if (target == 0) continue;
        Reservoir& r = exact[i];
        const double weight =
            target / (kCounts.map * double(lights.pdf[i]) + kCounts.bsdf * double(values->pdf[i]));
        r.sum += weight;
        const double p = weight / r.sum;
        if (r.x < p) r.kept = k, r.target = target;
        r.x = r.x < p ? r.x / p : (r.x - p) / (1 - p);
      }
      OfferCandidates(lights, values, kCounts, kRows, reservoirs);
    }
    soa::Table<LightColumns> out(kRows);
    TakeFromReservoirs(reservoirs, kRows, kSamples, out);
    std::uint32_t other = 0;
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const Reservoir& r = exact[i];
      if (r.kept < 0) {
        ASSERT_EQ(out->pdf[i], 0);
        ASSERT_EQ(out->r[i], 0);
        continue;
      }
      ASSERT_NEAR(reservoirs->sum[i], r.sum, 1e-5 * r.sum);
      const LightColumns& kept = candidates[std::size_t(r.kept)];
      if (out->dir_x[i] != kept.dir_x[i]) {
        ++other;  // the choice is within rounding
        continue;
      }
      const double worth = r.sum / (r.target * kSamples);
      ASSERT_NEAR(out->r[i], kept.r[i] * worth, 1e-5 * kept.r[i] * worth);
      ASSERT_NEAR(out->b[i], kept.b[i] * worth, 1e-5 * kept.b[i] * worth);
      ASSERT_TRUE(std::isinf(out->pdf[i]));
    }
    EXPECT_LE(other, kRows / 500);
  });
}

}  // namespace
}  // namespace skywave
