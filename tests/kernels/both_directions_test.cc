// Evaluates BSDFs in both directions, as connected sub-paths need: the reverse density is the
// density with exchanged roles, and the reverse value obeys reciprocity.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>

#include "kernels/bsdf/bsdf.h"
#include "kernels/light_paths/flux.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/bsdf_formulas.h"
#include "tests/support/targets.h"
#include "wavefront/stages/bidirectional.h"

namespace skywave {
namespace {

constexpr std::uint32_t kRows = 1000;

bool Transmits(const MaterialCase& material) {
  return Bsdfs()[std::size_t(material.kind)].transmits;
}

SurfaceRanges RangesOf(BsdfKind kind, std::uint32_t n) {
  SurfaceRanges ranges;
  for (std::uint32_t k = std::uint32_t(kind); k < kBsdfKinds; ++k) ranges.begin[k + 1] = n;
  return ranges;
}

// One material seen along random pairs of directions, half of them near the mirror direction.
struct Pairs {
  // With `bent`, geometric normals are random and shading normals deviate from them; otherwise both
  // are z.
  Pairs(const MaterialCase& of, bool bent, std::uint32_t seed)
      : material(of),
        wo(kRows),
        wi(kRows),
        ns(kRows, {0, 0, 1}),
        ng(kRows, {0, 0, 1}),
        rows(of, kRows, {0, 0, 1}, {0, 0, 1}),
        lights(kRows),
        turned(kRows),
        seen(kRows) {
    Random random(seed);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      if (bent) {
        ng[i] = random.Direction();
        ns[i] = Unit(ng[i] + 0.3 * random.Direction());
      }
      do {
        wo[i] = AtAngle(ns[i], random.Between(0.05, 1));
      } while (Dot(wo[i], ng[i]) < 0.02 && !(ns[i] = ng[i], false));
      wi[i] = random.Direction();
      const Vec mirror = 2 * Dot(wo[i], ns[i]) * ns[i] - wo[i];
      const double spread = LobeWidth(of) * random.Between(0, 2);
      if (i % 2 == 0) wi[i] = Unit(mirror + spread * random.Direction());
      rows.Set(i, ns[i], ng[i], wo[i]);
      Put(wi[i], i, lights->dir_x, lights->dir_y, lights->dir_z);
    }
  }
  void Evaluate() {
    EvaluateBothDirections(rows.materials(), rows.surfaces, RangesOf(material.kind, kRows), lights,
                           turned, seen);
  }

  const MaterialCase& material;
  std::vector<Vec> wo, wi, ns, ng;
  ShadingRows rows;
  soa::Table<LightColumns> lights;
  soa::Table<TurnedColumns> turned;
  BothDirections seen;
};

// The expected values are those of a path that arrives from wi at the same point: its normals face
// wi, and it sees the other face if wi is on that side.
TEST(BothDirections, BackwardsIsForwardsWithExchangedRoles) {
  std::uint32_t seed = 1;
  for (const MaterialCase& material : DenseCases()) {
    SCOPED_TRACE(material.name);
    for (const bool bent : {false, true}) {
      Pairs pairs(material, bent, seed++);
      ShadingRows exchanged(material, kRows, {0, 0, 1}, {0, 0, 1});
      soa::Table<LightColumns> back(kRows);
      soa::Table<NormalColumns> facing(kRows);
      FaceNormals(pairs.rows.surfaces, pairs.lights, kRows, facing);
      std::vector<bool> nothing(kRows);
      for (std::uint32_t i = 0; i < kRows; ++i) {
        const double side = Dot(pairs.wi[i], pairs.ng[i]) < 0 ? -1 : 1;
        // Nothing arrives from below a surface that transmits nothing.
        nothing[i] = side < 0 && !Transmits(material);
        const Vec ns = Get(i, facing->x, facing->y, facing->z);
        exchanged.Set(i, side * ns, side * pairs.ng[i], pairs.wi[i]);
        exchanged.surfaces->base_normal[i] = pairs.rows.surfaces->base_normal[i];
        if (side < 0) exchanged.surfaces->material[i] ^= kBackFace;
        Put(pairs.wo[i], i, back->dir_x, back->dir_y, back->dir_z);
      }
      soa::Table<BsdfValueColumns> forward(kRows), expected(kRows);
      ForEachTarget([&] {
        pairs.Evaluate();
        pairs.rows.kernels.evaluate(pairs.rows.surfaces, pairs.rows.materials(), pairs.lights,
                                    kRows, forward);
        exchanged.kernels.evaluate(exchanged.surfaces, exchanged.materials(), back, kRows,
                                   expected);
        for (std::uint32_t i = 0; i < kRows; ++i) {
          if (!nothing[i]) continue;
          expected->r[i] = expected->g[i] = expected->b[i] = expected->pdf[i] = 0;
        }
        EXPECT_EQ(ColumnBits(pairs.seen.forward.columns(), kRows),
                  ColumnBits(forward.columns(), kRows));
        EXPECT_EQ(ColumnBits(pairs.seen.backward.columns(), kRows),
                  ColumnBits(expected.columns(), kRows));
      });
    }
  }
}

TEST(BothDirections, DensityBackIsTheFormulas) {
  std::uint32_t seed = 101;
  std::size_t compared = 0;
  for (const MaterialCase& material : DenseCases()) {
    SCOPED_TRACE(material.name);
    Pairs pairs(material, false, seed++);
    pairs.Evaluate();
    const double c = std::cos(material.turn), s = std::sin(material.turn);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      Vec wo = pairs.wo[i], wi = pairs.wi[i];
      if (std::fabs(wi.z) < 1e-2 || (wi.z < 0 && !Transmits(material))) continue;
      MaterialCase seen = material;
      if (wi.z < 0) wo = -wo, wi = -wi, seen.back = !material.back;
      const auto turned = [&](Vec w) { return Vec{c * w.x + s * w.y, c * w.y - s * w.x, w.z}; };
      const FormulaValue value = BsdfFormula(seen, turned(wi), turned(wo));
      if (!value.known) continue;
      const double tolerance = 3e-4 + 1e-5 / LobeWidth(material) / std::fabs(wi.z);
      ASSERT_NEAR(pairs.seen.backward->pdf[i], value.pdf, tolerance * value.pdf + 1e-6)
          << "row " << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 10000u);
}

// f(wo, wi) = f(wi, wo); across an interface, f / n^2 with the index on the side to which radiance
// goes is reciprocal (Veach 1997, eq. 5.14).
TEST(BothDirections, ValuesAreReciprocal) {
  std::uint32_t seed = 201;
  for (const MaterialCase& material : DenseCases()) {
    if (IsTilted(material)) continue;  // as with all bent normals (Veach 1997, 5.3)
    SCOPED_TRACE(material.name);
    Pairs pairs(material, false, seed++);
    pairs.Evaluate();
    const double ratio = TransmissionRatio(material).value_or(1);
    double largest = 0;
    for (std::uint32_t i = 0; i < kRows; ++i) {
      largest = std::max(largest, double(pairs.seen.forward->g[i]));
    }
    ASSERT_GT(largest, 0);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const double cos_o = std::fabs(pairs.wo[i].z), cos_i = std::fabs(pairs.wi[i].z);
      if (cos_i < 1e-2) continue;
      const double scale = pairs.wi[i].z < 0 ? ratio * ratio : 1;
      const double forward = pairs.seen.forward->g[i] / cos_i;
      const double backward = scale * pairs.seen.backward->g[i] / cos_o;
      const double tolerance = 1e-3 + 2e-5 / LobeWidth(material) / std::min(cos_o, cos_i);
      ASSERT_NEAR(forward, backward, tolerance * forward + 1e-5 * largest) << "row " << i;
    }
  }
}

}  // namespace
}  // namespace skywave
