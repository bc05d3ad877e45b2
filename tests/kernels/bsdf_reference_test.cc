// Compares the kernels of BSDFs with a density with scalar double arithmetic: values and densities
// with the oracle's formulae, sampled directions with the same sampling in double, and the
// conductor's table with a quadrature that does not use visible normals.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "kernels/bsdf/dielectric_tables.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/bsdf_formulas.h"
#include "tests/support/facet_quadrature.h"
#include "tests/support/oracle_bsdf.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr std::uint32_t kRows = 4000;

std::vector<MaterialCase> Materials() {
  return {{"Lambert", BsdfKind::kLambert, {.color = {0.2f, 0.5f, 0.8f}}},
          {"White", BsdfKind::kConductor, WhiteConductor(0.5f)},
          {"Gold", BsdfKind::kConductor, GoldConductor(0.15f)},
          {"Rough", BsdfKind::kConductor, GoldConductor(0.9f)}};
}

OracleMaterial Exact(const MaterialCase& material) {
  const MaterialRecord& r = material.record;
  return MakeOracleMaterial({.bsdf = material.kind,
                             .reflectance = {r.color[0], r.color[1], r.color[2]},
                             .eta = {r.eta[0], r.eta[1], r.eta[2]},
                             .k = {r.k[0], r.k[1], r.k[2]},
                             .alpha = r.alpha});
}
glm::dvec3 Glm(Vec v) { return {v.x, v.y, v.z}; }

TEST(BsdfReference, ValuesAndDensities) {
  Random random(1);
  for (const MaterialCase& material : Materials()) {
    const OracleMaterial exact = Exact(material);
    ShadingRows rows(material, kRows, {0, 0, 1}, {0, 0, 1});
    std::vector<Vec> normals(kRows), wos(kRows), wis(kRows);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      normals[i] = random.Direction();
      wos[i] = AtAngle(normals[i], random.Between(0.05, 1));
      wis[i] = random.Direction();
      rows.Set(i, normals[i], normals[i], wos[i]);
    }
    ForEachTarget([&] {
      const auto seen = rows.Evaluate(wis);
      for (std::uint32_t i = 0; i < kRows; ++i) {
        const OracleSurface surface = {&exact, Glm(wos[i]), Glm(normals[i]), Glm(normals[i]),
                                       false};
        if (Dot(wis[i], normals[i]) <= 0) {
          ASSERT_EQ(seen->r[i] + seen->g[i] + seen->b[i] + seen->pdf[i], 0) << "row " << i;
          continue;
        }
        if (Dot(wis[i], normals[i]) < 1e-3) continue;
        const OracleValue value = EvaluateBsdf(surface, Glm(wis[i]));
        const double tolerance = 2e-4;
        ASSERT_NEAR(seen->pdf[i], value.pdf, tolerance * value.pdf) << material.name << " " << i;
        ASSERT_NEAR(seen->r[i], value.value.x, tolerance * value.value.x)
            << material.name << " " << i;
        ASSERT_NEAR(seen->g[i], value.value.y, tolerance * value.value.y)
            << material.name << " " << i;
        ASSERT_NEAR(seen->b[i], value.value.z, tolerance * value.value.z)
            << material.name << " " << i;
      }
    });
  }
}

// The other BSDFs are compared with their formulae along random pairs of directions, half of them
// near the mirror direction.
TEST(BsdfReference, Formulae) {
  const Vec normal = {0, 0, 1};  // its frame is the world's
  for (const MaterialCase& material : DenseCases()) {
    using enum BsdfKind;
    if (material.kind == kLambert || material.kind == kConductor) continue;  // ValuesAndDensities
    ShadingRows rows(material, kRows, normal, normal);
    Random random(23);
    std::vector<Vec> wos(kRows), wis(kRows);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      wos[i] = AtAngle(normal, random.Between(0.05, 1));
      wis[i] = random.Direction();
      const Vec mirror = {-wos[i].x, -wos[i].y, wos[i].z};
      const double spread = LobeWidth(material) * random.Between(0, 3);
      if (i % 2 == 0) wis[i] = Unit(mirror + spread * random.Direction());
      rows.Set(i, normal, normal, wos[i]);
    }
    const double c = std::cos(material.turn), s = std::sin(material.turn);
    const auto turned = [&](Vec w) { return Vec{c * w.x + s * w.y, c * w.y - s * w.x, w.z}; };
    const bool transmits = Bsdfs()[std::size_t(material.kind)].transmits;
    ForEachTarget([&] {
      const auto seen = rows.Evaluate(wis);
      double largest = 0;
      for (std::uint32_t i = 0; i < kRows; ++i) largest = std::max(largest, double(seen->g[i]));
      for (std::uint32_t i = 0; i < kRows; ++i) {
        if (std::fabs(wis[i].z) < 1e-2 || (wis[i].z < 0 && !transmits)) continue;
        const double base_o = Dot(material.base_normal, turned(wos[i]));
        if (base_o < 0.05 || std::fabs(Dot(material.base_normal, turned(wis[i]))) < 1e-2) continue;
        const FormulaValue exact = BsdfFormula(material, turned(wos[i]), turned(wis[i]));
        if (!exact.known) continue;
        // Float directions have errors of 1e-7, and the value of a narrow lobe changes by that over
        // its width.
        const double tolerance = 3e-4 + 1e-5 / LobeWidth(material);
        const double floor = 1e-6 * largest;
        const float rgb[3] = {seen->r[i], seen->g[i], seen->b[i]};
        for (int channel = 0; channel < 3; ++channel) {
          ASSERT_NEAR(rgb[channel], exact.rgb[channel], tolerance * exact.rgb[channel] + floor)
              << material.name << ", row " << i << ", channel " << channel;
        }
        ASSERT_NEAR(seen->pdf[i], exact.pdf, tolerance * exact.pdf + floor)
            << material.name << ", row " << i;
      }
    });
  }
}

// The direction follows from a visible normal by the spherical cap of Dupuy and Benyoub 2023, or
// from the cosine if the lobe of multiple scattering is chosen; that has a frame of its own, so
// heights are compared.
TEST(BsdfReference, DirectionsDrawn) {
  const Vec normal = {0, 0, 1};
  for (const MaterialCase& material : Materials()) {
    const double alpha = material.record.alpha;
    for (const double cosine : {0.2, 0.7, 1.0}) {
      const Vec wo = AtAngle(normal, cosine);
      const ShadingRows rows(material, kRows, normal, wo);
      const ScatterRows uniforms(kRows, 21);
      const OracleMaterial exact = Exact(material);
      ForEachTarget([&] {
        soa::Table<RayColumns> rays(kRows);
        const std::uint32_t alive = rows.kernels.scatter(rows.surfaces, rows.materials(),
                                                         uniforms.view(), kRows, {}, rays, 0);
        std::uint32_t ray = 0, other_lobe = 0;
        for (std::uint32_t i = 0; i < kRows && ray < alive; ++i) {
          if (rays->from[ray] != i) continue;  // absorbed
          const double u = uniforms.direction->u[i], v = uniforms.direction->v[i];
          const Vec wi = RayDirection(rays, ray++);
          const double diffuse_height = std::sqrt(1 - v);
          if (material.kind == BsdfKind::kLambert) {
            ASSERT_NEAR(wi.z, diffuse_height, 1e-6);
            continue;
          }
          // The frame of a normal along z is the world's.
          const Vec view = Unit({alpha * wo.x, alpha * wo.y, wo.z});
          const double cap = 1 - v * (1 + view.z), radius = std::sqrt(std::max(0.0, 1 - cap * cap));
          const Vec h = Unit({alpha * (radius * std::cos(2 * kPi * u) + view.x),
                              alpha * (radius * std::sin(2 * kPi * u) + view.y),
                              std::max(cap + view.z, 1e-7)});
          const Vec mirrored = 2 * Dot(wo, h) * h - wo;
          const bool reflected = Angle(wi, mirrored) < 1e-3;
          if (!reflected) {
            ASSERT_NEAR(wi.z, diffuse_height, 1e-6) << material.name << ", row " << i;
            ++other_lobe;
          }
          const OracleValue value =
              EvaluateBsdf({&exact, Glm(wo), Glm(normal), Glm(normal), false}, Glm(wi));
          if (wi.z < 1e-2) continue;
          ASSERT_NEAR(rays->pdf[ray - 1], value.pdf, 1e-2 * value.pdf);
        }
        if (material.name == "Rough") {
          EXPECT_GT(other_lobe, 0u);
        }
      });
    }
  }
}

// Albedos of the lobe where F is 1, and where it is (1 - wo.h)^5.
struct LobeAlbedos {
  double all = 0, grazing = 0;
};
// Computes E(mu) with half vectors distributed as D(h) cos: the integral of F G2 (wo.h) / (cos_o
// h.z).
LobeAlbedos Albedo(double alpha, double mu, int radii, int turns) {
  const Vec wo = {std::sqrt(1 - mu * mu), 0, mu};
  const auto lambda = [&](double z) {
    return 0.5 * (std::sqrt(1 + alpha * alpha * (1 - z * z) / (z * z)) - 1);
  };
  LobeAlbedos sum;
  for (int i = 0; i < radii; ++i) {
    const double u = (i + 0.5) / radii, tangent = alpha * std::sqrt(u / (1 - u));
    const double hz = 1 / std::sqrt(1 + tangent * tangent), sine = tangent * hz;
    for (int j = 0; j < turns; ++j) {
      const double phi = kPi * (j + 0.5) / turns;
      const Vec h = {sine * std::cos(phi), sine * std::sin(phi), hz};
      const double facing = Dot(wo, h), wiz = 2 * facing * hz - mu;
      if (facing <= 0 || wiz <= 0) continue;
      const double kept = facing / (mu * hz) / (1 + lambda(mu) + lambda(std::min(wiz, 1.0)));
      const double away = std::max(1 - facing, 0.0), away2 = away * away;
      sum.all += kept, sum.grazing += kept * away2 * away2 * away;
    }
  }
  const double count = double(radii) * turns;
  return {sum.all / count, sum.grazing / count};
}

TEST(BsdfReference, AlbedosOfTheFacets) {
  const ConductorTables& tables = GgxTables();
  for (const std::uint32_t row : {6u, 12u, 18u, 25u, 31u}) {
    const double alpha = std::pow(row / double(kAlbedoRows - 1), 2);
    for (const std::uint32_t column : {6u, 10u, 16u, 24u, 31u}) {
      const double mu = std::pow(column / double(kAlbedoColumns - 1), 2);
      const LobeAlbedos exact = Albedo(alpha, mu, alpha < 0.1 ? 40000 : 8000, 400);
      const std::uint32_t at = row * (kAlbedoColumns + 1) + column;
      EXPECT_NEAR(tables.albedo[at], exact.all, 1.5e-3) << "alpha " << alpha << ", cosine " << mu;
      EXPECT_NEAR(tables.grazing[at], exact.grazing, 1.5e-3)
          << "alpha " << alpha << ", cosine " << mu;
    }
    LobeAlbedos mean;
    constexpr int kSteps = 40;
    for (int i = 0; i < kSteps; ++i) {
      const double mu = (i + 0.5) / kSteps;
      const LobeAlbedos exact = Albedo(alpha, mu, 2000, 100);
      mean.all += 2 * mu / kSteps * exact.all, mean.grazing += 2 * mu / kSteps * exact.grazing;
    }
    EXPECT_NEAR(tables.mean_albedo[row], mean.all, 1.5e-3) << "alpha " << alpha;
    EXPECT_NEAR(tables.mean_grazing[row], mean.grazing, 1.5e-3) << "alpha " << alpha;
  }
}

// The tables of glass and of brushed metal hold what a quadrature without visible normals finds.
TEST(BsdfReference, LossesOfRoughGlass) {
  for (const float ior : {1.2f, 1.5f, 0.7f}) {
    for (const float alpha : {0.15f, 0.5f, 1.0f}) {
      const DielectricRow row = MakeDielectricTable(alpha, ior).rows[3];
      for (const bool inside : {false, true}) {
        const double ratio = inside ? ior : 1 / ior;
        const auto lost = [&](double mu, int radii, int turns) {
          const glm::dvec3 wo = {std::sqrt(1 - mu * mu), 0, mu};
          return 1 - KeptByFacets(alpha, alpha, wo, ratio, radii, turns);
        };
        for (const std::size_t column : {10u, 16u, 24u, 31u}) {
          const double mu = std::pow(double(column) / (kAlbedoColumns - 1), 2);
          EXPECT_NEAR(row.lost[inside][column], lost(mu, 1000, 100), 2e-3)
              << "ior " << ior << ", alpha " << alpha << ", cosine " << mu << ", side " << inside;
        }
        double mean = 0;
        constexpr int kSteps = 40;
        for (int i = 0; i < kSteps; ++i) {
          const double mu = (i + 0.5) / kSteps;
          mean += 2 * mu / kSteps * lost(mu, 300, 60);
        }
        EXPECT_NEAR(row.mean[inside], mean, 2e-3) << "ior " << ior << ", alpha " << alpha;
      }
    }
  }
}

TEST(BsdfReference, AlbedosOfBrushedMetal) {
  const AnisotropicTables& tables = GetAnisotropicTables();
  const auto square = [](std::size_t place, std::size_t count) {
    return std::pow(double(place) / double(count - 1), 2);
  };
  for (const std::size_t a : {4u, 8u, 11u}) {
    for (const std::size_t b : {3u, 7u, 11u}) {
      const double along = square(a, kTabledWidths), across = square(b, kTabledWidths);
      for (const std::size_t c : {5u, 9u, 13u, 15u}) {
        for (const std::size_t p : {0u, 4u, 7u, 12u}) {
          const double mu = square(c, kTabledCosines), sine = std::sqrt(1 - mu * mu);
          const double share = double(p) / (kTabledAzimuths - 1), x = 1 - share, y = share;
          const double norm = std::hypot(x, y);
          const glm::dvec3 wo = {sine * x / norm, -sine * y / norm, mu};
          EXPECT_NEAR(tables.albedo[a][b][c][p], KeptByFacets(along, across, wo, {}, 800, 100),
                      3e-3)
              << "widths " << along << " and " << across << ", cosine " << mu << ", azimuth " << p;
        }
      }
      double mean = 0;
      constexpr int kSteps = 24;
      for (int i = 0; i < kSteps; ++i) {
        for (int j = 0; j < kSteps; ++j) {
          const double mu = (i + 0.5) / kSteps, phi = kPi / 2 * (j + 0.5) / kSteps;
          const double sine = std::sqrt(1 - mu * mu);
          const glm::dvec3 wo = {sine * std::cos(phi), sine * std::sin(phi), mu};
          mean += 2 * mu / (kSteps * kSteps) * KeptByFacets(along, across, wo, {}, 200, 60);
        }
      }
      EXPECT_NEAR(tables.mean_albedo[a][b], mean, 4e-3) << "widths " << along << ", " << across;
    }
  }
}

// Integrates Charlie's lobe (Estevez and Kulla 2017) with Neubelt's visibility over wi.
double SheenIntegral(double alpha, double mu) {
  constexpr int kHeights = 400, kTurns = 200;
  const Vec wo = {std::sqrt(1 - mu * mu), 0, mu};
  double sum = 0;
  for (int i = 0; i < kHeights; ++i) {
    // The step is in the root of the height, which resolves grazing directions.
    const double root = (i + 0.5) / kHeights, z = root * root, step = 2 * root / kHeights;
    for (int j = 0; j < kTurns; ++j) {
      const double phi = 2 * kPi * (j + 0.5) / kTurns, r = std::sqrt(1 - z * z);
      const Vec wi = {r * std::cos(phi), r * std::sin(phi), z};
      const Vec h = Unit(wo + wi);
      const double d = (2 + 1 / alpha) / (2 * kPi) * std::pow(std::hypot(h.x, h.y), 1 / alpha);
      sum += d / (4 * (mu + z - mu * z)) * z * step * 2 * kPi / kTurns;
    }
  }
  return sum;
}

TEST(BsdfReference, AlbedoOfTheSheen) {
  const SheenTables& tables = GetSheenTables();
  for (const std::uint32_t row : {8u, 14u, 20u, 31u}) {
    const double alpha = std::pow(row / double(kAlbedoRows - 1), 2);
    double largest = 1;
    for (std::uint32_t column = 1; column < kAlbedoColumns; ++column) {
      const double mu = std::pow(column / double(kAlbedoColumns - 1), 2);
      const double albedo = SheenIntegral(alpha, mu);
      largest = std::max(largest, albedo);
      EXPECT_NEAR(tables.albedo[row * (kAlbedoColumns + 1) + column], albedo * tables.scale[row],
                  0.01)
          << "alpha " << alpha << ", cosine " << mu;
    }
    EXPECT_LE(tables.scale[row] * largest, 1.01) << "alpha " << alpha;
    EXPECT_GE(tables.scale[row] * largest, 0.95) << "alpha " << alpha;
  }
}

}  // namespace
}  // namespace skywave
