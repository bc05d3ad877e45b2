// Tests that sampling, evaluation and energy of BSDFs with a density agree.

#include "kernels/bsdf/bsdf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "kernels/bsdf/material.h"
#include "tests/support/bsdf_albedo.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/bsdf_formulas.h"
#include "tests/support/bsdf_rounding.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

const std::vector<MaterialCase>& Materials() { return DenseCases(); }
const double kCosines[] = {1.0, 0.9, 0.6, 0.3, 0.1, 0.02};

// The frame of the first normal is the world's; the second one points into the lower half.
const Vec kNormals[] = {{0, 0, 1}, Unit({0.5, -0.3, -0.7})};

// Divides the hemisphere of wi into cells by the half vector h of wi and wo about the normal: by
// its azimuth and by q(r) = (r / (r + width) + r / (r + 1)) / 2, where r is the tangent of its
// angle. With width = alpha, the first summand resolves the GGX lobe, however narrow the lobe and
// however grazing wo; the second one resolves diffuse parts. For transmissive surfaces the other
// hemisphere is divided likewise: by the facet that refracts wo to wi (`ratio`: near index over far
// index) or, with ratio 1, by the mirrored cells. Directions to which no facet refracts are divided
// by squared cosine and azimuth.
class HalfVectorCells {
 public:
  static constexpr int kBins = 16;  // along each side
  static constexpr int kAllBins = 3 * kBins * kBins;

  HalfVectorCells(Vec normal, Vec wo, double width, int finer, std::optional<double> ratio = {})
      : n_(normal),
        s_(Unit(Cross(normal, {0.1, 0.7, -0.5}))),
        t_(Cross(n_, s_)),
        wo_(wo),
        width_(width),
        ratio_(ratio.value_or(1)) {
    const int side = kBins * finer;
    for (int a = 0; a < side; ++a) {
      for (int b = 0; b < side; ++b) {
        if (ratio_ != 1) AddUnreached(a, b, side);
        const double q = (a + 0.5) / side, phi = 2 * kPi * (b + 0.5) / side;
        const double tangent = Tangent(q), cosine = 1 / std::sqrt(1 + tangent * tangent);
        const double sine = tangent * cosine;
        const Vec h = sine * std::cos(phi) * s_ + sine * std::sin(phi) * t_ + cosine * n_;
        const double toward = Dot(h, wo);
        const Vec wi = 2 * toward * h - wo;
        const double dslope = tangent / Slope(tangent) * 2 * kPi / side / side;
        const double dh = cosine * cosine * cosine * dslope;
        const auto bin = std::size_t(a / finer * kBins + b / finer);
        if (ratio) AddBelow(h, toward, dh, bin + kBins * kBins);
        if (toward <= 0 || Dot(wi, n_) <= 0) continue;
        // dh = cos^3 dslope, dslope = r dr dphi, and dwi = 4 (wo . h) dh (Walter et al. 2007, eq.
        // 14).
        directions_.push_back(wi);
        solid_angles_.push_back(4 * toward * dh);
        bins_.push_back(bin);
      }
    }
  }
  const std::vector<Vec>& directions() const { return directions_; }
  double solid_angle(std::size_t cell) const { return solid_angles_[cell]; }
  std::size_t bin(std::size_t cell) const { return bins_[cell]; }
  std::size_t BinOf(Vec wi) const {
    const bool below = Dot(wi, n_) < 0;
    if (below && Unreached(wi)) return UnreachedBin(wi);
    Vec h = wi + wo_;
    if (below) h = ratio_ == 1 ? Mirrored(wi) + wo_ : ratio_ * wo_ + wi;
    if (Dot(h, n_) < 0) h = -h;
    const double x = Dot(h, s_), y = Dot(h, t_), z = Dot(h, n_);
    const double tangent = std::hypot(x, y) / z;
    const double q = (tangent / (tangent + width_) + tangent / (tangent + 1)) / 2;
    const double turn = std::atan2(y, x) / (2 * kPi);
    const int place = Bin(q) * kBins + Bin(turn < 0 ? turn + 1 : turn);
    return std::size_t(below ? place + kBins * kBins : place);
  }

 private:
  static int Bin(double at) { return std::clamp(int(at * kBins), 0, kBins - 1); }
  // Returns true if no facet refracts wo to wi, which is below: the facet has to lie between both.
  bool Unreached(Vec wi) const {
    if (ratio_ == 1) return false;
    Vec h = ratio_ * wo_ + wi;
    if (Dot(h, n_) < 0) h = -h;
    return !(Dot(h, wo_) > 0 && Dot(h, wi) < 0);
  }
  std::size_t UnreachedBin(Vec wi) const {
    const double height = Dot(wi, n_);
    const double turn = std::atan2(Dot(wi, t_), Dot(wi, s_)) / (2 * kPi);
    return std::size_t(2 * kBins * kBins + Bin(height * height) * kBins +
                       Bin(turn < 0 ? turn + 1 : turn));
  }
  // Adds the directions of a cell of squared cosines and azimuths to which no facet refracts. The
  // lowest row is cut finer, into equal cosines: some light is unreached at grazing angles alone.
  void AddUnreached(int a, int b, int side) {
    const double phi = 2 * kPi * (b + 0.5) / side, dphi = 2 * kPi / side;
    const int pieces = a == 0 ? 32 : 1;
    const double least = std::sqrt(double(a) / side), most = std::sqrt((a + 1.0) / side);
    const double dz = (most - least) / pieces;
    for (int piece = 0; piece < pieces; ++piece) {
      const double z = least + dz * (piece + 0.5), sine = std::sqrt(1 - z * z);
      const Vec wi = sine * std::cos(phi) * s_ + sine * std::sin(phi) * t_ - z * n_;
      if (!Unreached(wi)) continue;
      directions_.push_back(wi);
      solid_angles_.push_back(dz * dphi);
      bins_.push_back(UnreachedBin(wi));
    }
  }
  Vec Mirrored(Vec w) const { return w - 2 * Dot(w, n_) * n_; }
  void AddBelow(Vec h, double toward, double dh, std::size_t bin) {
    const double sine2 = ratio_ * ratio_ * (1 - toward * toward);
    if (toward <= 0 || (ratio_ != 1 && sine2 >= 1)) return;
    // This is Snell's law, and dwi = dh (ratio wo . h + wi . h)^2 / |wi . h| (Walter et al. 2007,
    // eq. 17).
    const double inside = -std::sqrt(1 - sine2);
    Vec wi = (ratio_ * toward + inside) * h - ratio_ * wo_;
    double dwi = dh * std::pow(ratio_ * toward + inside, 2) / -inside;
    if (ratio_ == 1) wi = Mirrored(2 * toward * h - wo_), dwi = 4 * toward * dh;
    if (Dot(wi, n_) >= 0) return;
    directions_.push_back(wi);
    solid_angles_.push_back(dwi);
    bins_.push_back(bin);
  }
  // Tangent() inverts q(r) by a quadratic equation; Slope() is dq/dr.
  double Tangent(double q) const {
    const double b = (1 - 2 * q) * (1 + width_);
    const double root = std::sqrt(b * b + 16 * (1 - q) * q * width_);
    return b > 0 ? 4 * q * width_ / (b + root) : (root - b) / (4 * (1 - q));
  }
  double Slope(double r) const {
    return 0.5 * (width_ / ((r + width_) * (r + width_)) + 1 / ((r + 1) * (r + 1)));
  }

  Vec n_, s_, t_, wo_;
  double width_, ratio_;
  std::vector<Vec> directions_;
  std::vector<double> solid_angles_;
  std::vector<std::size_t> bins_;
};

using Case = std::tuple<std::size_t, std::size_t>;

class DenseBsdf : public testing::TestWithParam<Case> {
 protected:
  const MaterialCase& material_ = Materials()[std::get<0>(GetParam())];
  const double cosine_ = kCosines[std::get<1>(GetParam())];
  static double Level() {
    return SidakLevel(Materials().size() * std::size(kCosines) * std::size(kNormals));
  }
};

// Compares counts in cells with the density. Samples below the horizon have a cell of their own:
// they account for everything that the integral of the density over the hemisphere lacks.
TEST_P(DenseBsdf, ScatterFollowsTheDensity) {
  constexpr std::uint32_t kSamples = 30000;
  for (const Vec normal : kNormals) {
    const Vec wo = AtAngle(normal, cosine_);
    // Phong's lobe is round about the mirror direction, so at grazing angles it is elongated in
    // half vectors.
    const bool grazing = material_.kind == BsdfKind::kPhong && cosine_ < 0.1;
    const HalfVectorCells cells(normal, wo, LobeWidth(material_), grazing ? 48 : 16,
                                TransmissionRatio(material_));
    const auto count = std::uint32_t(cells.directions().size());
    const ShadingRows rows(material_, std::max(kSamples, count), normal, wo);
    const auto density = rows.Evaluate(cells.directions());
    const std::size_t bins = HalfVectorCells::kAllBins;
    std::vector<double> expected(bins + 1), observed(bins + 1);
    double integral = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      ASSERT_TRUE(std::isfinite(density->pdf[i]) && density->pdf[i] >= 0);
      const double share = density->pdf[i] * cells.solid_angle(i);
      integral += share, expected[cells.bin(i)] += kSamples * share;
    }
    expected[bins] = std::max(0.0, kSamples * (1 - integral));
    ASSERT_LT(integral, 1.003) << "quadrature";

    soa::Table<RayColumns> rays(kSamples);
    const ScatterRows uniforms(kSamples, 31);
    const std::uint32_t alive = rows.kernels.scatter(rows.surfaces, rows.materials(),
                                                     uniforms.view(), kSamples, {}, rays, 0);
    for (std::uint32_t i = 0; i < alive; ++i) ++observed[cells.BinOf(RayDirection(rays, i))];
    observed[bins] = kSamples - alive;
    if (material_.kind == BsdfKind::kLambert) {
      EXPECT_EQ(alive, kSamples) << "nothing to lose";
      EXPECT_NEAR(integral, 1, 3e-3);
    }
    EXPECT_TRUE(MatchesExpected(observed, expected, Level(), 1e-3 * kSamples))
        << "integral of the density " << integral << ", alive " << double(alive) / kSamples;
  }
}

// Rounding errors of multiplications and polynomials, excluding those of the directions.
constexpr double kArithmetic = 1e-5;

TEST_P(DenseBsdf, WeightIsValueOverDensity) {
  constexpr std::uint32_t kSamples = 600;
  for (const Vec normal : kNormals) {
    const Vec wo = AtAngle(normal, cosine_);
    const ShadingRows rows(material_, kSamples, normal, wo);
    soa::Table<RayColumns> rays(kSamples);
    const ScatterRows uniforms(kSamples, 33);
    const std::uint32_t alive = rows.kernels.scatter(rows.surfaces, rows.materials(),
                                                     uniforms.view(), kSamples, {}, rays, 0);
    std::vector<Vec> directions(alive);
    for (std::uint32_t i = 0; i < alive; ++i) directions[i] = RayDirection(rays, i);
    const auto seen = rows.Evaluate(directions);
    const TangentFrame frame(normal, material_.turn);
    for (std::uint32_t i = 0; i < alive; ++i) {
      ASSERT_NEAR(Length(directions[i]), 1, 1e-5);
      const double height = Dot(directions[i], normal);
      ASSERT_TRUE(height > 0 || TransmissionRatio(material_));
      // A direction near the horizon has only an absolute precision.
      if (std::fabs(height) < 1e-3) continue;
      // Both values are the formula at directions that differ by rounding: five errors per
      // component from the frame to the world, five back, and as many again in the vectors of the
      // frame.
      const Vec eye = frame.To(wo), light = frame.To(directions[i]);
      const FormulaValue exact = BsdfFormula(material_, eye, light);
      if (!exact.known) continue;
      const FormulaValue change = ChangeByRounding(material_, eye, light, 24);
      const double tolerance = kArithmetic + change.pdf / exact.pdf;
      ASSERT_NEAR(rays->pdf[i] / seen->pdf[i], 1, tolerance) << "row " << i;
      const float weights[3] = {rays->throughput_r[i], rays->throughput_g[i],
                                rays->throughput_b[i]};
      const float values[3] = {seen->r[i], seen->g[i], seen->b[i]};
      for (int c = 0; c < 3; ++c) {
        const double weight = double(values[c]) / seen->pdf[i];
        const double of_value = exact.rgb[c] > 0 ? change.rgb[c] / exact.rgb[c] : 0;
        ASSERT_NEAR(weights[c], weight, (tolerance + of_value) * weight)
            << "row " << i << ", channel " << c;
      }
    }
  }
}

std::string CaseName(const testing::TestParamInfo<Case>& info) {
  return Materials()[std::get<0>(info.param)].name + "_cos" +
         std::to_string(int(kCosines[std::get<1>(info.param)] * 100));
}
INSTANTIATE_TEST_SUITE_P(All, DenseBsdf,
                         testing::Combine(testing::Range(std::size_t{0}, Materials().size()),
                                          testing::Range(std::size_t{0}, std::size(kCosines))),
                         CaseName);

// The energy of single-scattering facets must be that of their formula, summed over cells in
// double. The kernels deviate by the errors of both sums, about 1e-4 each. Narrow lobes keep nearly
// all energy.
TEST(BsdfEnergy, FacetsKeepWhatTheirFormulaKeeps) {
  std::vector<MaterialCase> cases;
  for (const float alpha : {0.02f, 0.3f}) {
    const MaterialRecord record = {.color = {1, 1, 1}, .alpha = alpha, .ior = alpha / 2};
    for (const BsdfKind kind : {BsdfKind::kAnisotropicConductor, BsdfKind::kBeckmannConductor}) {
      cases.push_back({"facets", kind, record});
    }
    const MaterialRecord glass = {.color = {1, 1, 1}, .alpha = alpha, .ior = 1.5f};
    cases.push_back({"outside", BsdfKind::kRoughDielectric, glass, false});
    cases.push_back({"inside", BsdfKind::kRoughDielectric, glass, true});
  }
  const Vec normal = {0, 0, 1};
  for (const MaterialCase& material : cases) {
    const auto ratio = TransmissionRatio(material);
    for (const double cosine : {1.0, 0.6, 0.3}) {
      const Vec wo = AtAngle(normal, cosine);
      const HalfVectorCells cells(normal, wo, material.record.alpha, 32, ratio);
      double kept = 0;
      for (std::size_t i = 0; i < cells.directions().size(); ++i) {
        const Vec wi = cells.directions()[i];
        const double energy = wi.z < 0 ? 1 / (*ratio * *ratio) : 1;
        kept += energy * BsdfFormula(material, wo, wi).rgb[1] * cells.solid_angle(i);
      }
      EXPECT_NEAR(Albedo(material, cosine)[1], kept, 1e-3)
          << material.name << ", alpha " << material.record.alpha << ", cosine " << cosine;
      if (material.record.alpha < 0.1 && material.kind != BsdfKind::kRoughDielectric) {
        EXPECT_GT(kept, 0.99) << cosine;
      }
    }
  }
}

TEST(BsdfValue, IsReciprocal) {
  constexpr std::uint32_t kPairs = 2000;
  for (const MaterialCase& material : Materials()) {
    if (IsTilted(material)) continue;  // as with all bent normals (Veach 1997, 5.3)
    const Vec normal = kNormals[1];
    Random random(35);
    ShadingRows there(material, kPairs, normal, normal), back(material, kPairs, normal, normal);
    std::vector<Vec> wi(kPairs), wo(kPairs);
    for (std::uint32_t i = 0; i < kPairs; ++i) {
      wo[i] = random.DirectionAbout(normal);
      // Half of the pairs are near the mirror direction, where narrow lobes are.
      const Vec mirror = 2 * Dot(normal, wo[i]) * normal - wo[i];
      const double spread = LobeWidth(material) * random.Between(0, 3);
      wi[i] =
          i % 2 == 0 ? random.DirectionAbout(normal) : Unit(mirror + spread * random.Direction());
      there.Set(i, normal, normal, wo[i]);
      back.Set(i, normal, normal, wi[i]);
    }
    const auto a = there.Evaluate(wi), b = back.Evaluate(wo);
    for (std::uint32_t i = 0; i < kPairs; ++i) {
      const double cos_i = Dot(wi[i], normal), cos_o = Dot(wo[i], normal);
      if (cos_i < 1e-3 || cos_o < 1e-3) continue;
      const double f = a->r[i] / cos_i, reversed = b->r[i] / cos_o;
      ASSERT_NEAR(f, reversed, (5e-4 + 1e-6 / (cos_i * cos_o)) * std::max(f, reversed))
          << material.name << ", pair " << i;
    }
  }
}

// For transmission, f n_i^2 is symmetric under exchange of near and far (Veach 1997, eq. 5.14). The
// formula fulfils this to the last digits of double; the kernel deviates by the effect that
// rounding of its directions has on the formula. Near total internal reflection this effect is
// large because 1 - F behaves like the root of a difference of numbers near 1.
TEST(BsdfValue, TransmissionIsReciprocal) {
  constexpr std::uint32_t kPairs = 2000;
  for (const MaterialCase& material : Materials()) {
    const auto ratio = TransmissionRatio(material);
    if (!ratio || IsTilted(material)) continue;
    const Vec normal = {0, 0, 1};  // its frame is the world's
    const MaterialCase other = SeenFromBehind(material);
    const int roundings = material.turn == 0 ? 8 : 16;  // turning to the tangent rounds, too
    // A value this small, of those around 1, lies at the edge of total reflection, where it ends.
    constexpr double kEdge = 1e-8;
    const TangentFrame front(normal, material.turn), behind(-normal, other.turn);
    Random random(39);
    ShadingRows there(material, kPairs, normal, normal), back(other, kPairs, -normal, -normal);
    std::vector<Vec> wi(kPairs), wo(kPairs);
    for (std::uint32_t i = 0; i < kPairs; ++i) {
      wo[i] = random.DirectionAbout(normal);
      wi[i] = random.DirectionAbout(-normal);
      there.Set(i, normal, normal, wo[i]);
      back.Set(i, -normal, -normal, wi[i]);
    }
    const auto a = there.Evaluate(wi), b = back.Evaluate(wo);
    double sum = 0;
    for (std::uint32_t i = 0; i < kPairs; ++i) {
      const double cos_i = std::fabs(wi[i].z), cos_o = wo[i].z;
      if (cos_i < 1e-2 || cos_o < 1e-2) continue;
      const FormulaValue there_exact = BsdfFormula(material, front.To(wo[i]), front.To(wi[i]));
      const FormulaValue back_exact = BsdfFormula(other, behind.To(wi[i]), behind.To(wo[i]));
      const double f = there_exact.rgb[0] / cos_i / (*ratio * *ratio);
      const double reversed = back_exact.rgb[0] / cos_o;
      ASSERT_NEAR(f, reversed, 1e-9 * std::max(f, reversed)) << material.name << ", pair " << i;
      ASSERT_NEAR(
          a->r[i], there_exact.rgb[0],
          kEdge + 1e-5 * there_exact.rgb[0] +
              ChangeByRounding(material, front.To(wo[i]), front.To(wi[i]), roundings).rgb[0])
          << material.name << ", pair " << i;
      ASSERT_NEAR(b->r[i], back_exact.rgb[0],
                  kEdge + 1e-5 * back_exact.rgb[0] +
                      ChangeByRounding(other, behind.To(wi[i]), behind.To(wo[i]), roundings).rgb[0])
          << material.name << ", pair " << i;
      sum += f;
    }
    EXPECT_GT(sum, 0) << material.name;
  }
}

// Computes GGX in double from the formulas of the papers: D (Walter et al. 2007, eq. 33), Lambda
// (Heitz 2014, eq. 72), height-correlated G2, and G1, without the multiple-scattering lobe, which a
// black factor switches off.
TEST(BsdfValue, SingleScatteringMatchesTheFormula) {
  constexpr std::uint32_t kRows = 2000;
  for (const float alpha : {0.01f, 0.1f, 0.5f, 1.0f}) {
    MaterialRecord record = GoldConductor(alpha);
    record.color[0] = 0.9f, record.color[1] = 0.5f, record.color[2] = 0.1f;
    for (float& factor : record.multiscatter) factor = 0;
    const Vec normal = {0, 0, 1};
    ShadingRows rows({"", BsdfKind::kConductor, record}, kRows, normal, normal);
    Random random(36);
    std::vector<Vec> wi(kRows), wo(kRows);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      wo[i] = random.DirectionAbout(normal);
      const Vec mirror = {-wo[i].x, -wo[i].y, wo[i].z};
      wi[i] = Unit(mirror + alpha * random.Between(0, 2) * random.Direction());
      rows.Set(i, normal, normal, wo[i]);
    }
    const auto out = rows.Evaluate(wi);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      if (wi[i].z < 0.01 || wo[i].z < 0.01) continue;
      const Vec h = Unit(wi[i] + wo[i]);
      const double a2 = double(alpha) * alpha;
      const double d_root = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
      const double d = a2 / (kPi * d_root * d_root);
      const auto lambda = [&](Vec w) {
        return 0.5 * (std::sqrt(1 + a2 * (w.x * w.x + w.y * w.y) / (w.z * w.z)) - 1);
      };
      const double single = d / (1 + lambda(wi[i]) + lambda(wo[i])) / (4 * wo[i].z);
      const float values[3] = {out->r[i], out->g[i], out->b[i]};
      for (int c = 0; c < 3; ++c) {
        const double f = FresnelReflectance(Dot(wo[i], h), {record.eta[c], record.k[c]});
        const double exact = record.color[c] * f * single;
        ASSERT_NEAR(values[c], exact, (1e-4 + 2e-6 / alpha) * exact)
            << "alpha " << alpha << " row " << i;
      }
    }
  }
}

}  // namespace
}  // namespace skywave
