#include "tests/support/bsdf_rounding.h"

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

FormulaValue Distance(const FormulaValue& a, const FormulaValue& b) {
  FormulaValue out;
  for (int c = 0; c < 3; ++c) out.rgb[c] = std::fabs(a.rgb[c] - b.rgb[c]);
  out.pdf = std::fabs(a.pdf - b.pdf);
  return out;
}
FormulaValue Larger(const FormulaValue& a, const FormulaValue& b) {
  FormulaValue out;
  for (int c = 0; c < 3; ++c) out.rgb[c] = std::max(a.rgb[c], b.rgb[c]);
  out.pdf = std::max(a.pdf, b.pdf);
  return out;
}
void Add(const FormulaValue& more, double factor, FormulaValue& sum) {
  for (int c = 0; c < 3; ++c) sum.rgb[c] += factor * more.rgb[c];
  sum.pdf += factor * more.pdf;
}

// Returns the relative change of the refracted or, above the surface, the reflected fraction.
double FresnelChange(double ratio, Vec wo, Vec wi) {
  const Vec h = Unit(wi.z > 0 ? wo + wi : ratio * wo + wi);
  const double cosine = std::fabs(Dot(wo, h));
  const auto share = [&](double c) {
    const double reflected = FresnelReflectance(c, {1 / ratio, 0});
    return wi.z > 0 ? reflected : 1 - reflected;
  };
  const double moved = share(std::min(cosine + 0x1p-22, 1.0));
  return std::fabs(moved - share(cosine)) / std::max(share(cosine), 1e-30);
}

}  // namespace

FormulaValue ChangeByRounding(const MaterialCase& material, Vec wo, Vec wi, int roundings) {
  const double moved = 0x1p-24 * roundings;
  const FormulaValue middle = BsdfFormula(material, wo, wi);
  FormulaValue change;
  if (WithoutCoat(material.kind) == BsdfKind::kRoughDielectric) {
    MaterialCase denser = material;
    denser.record.ior *= 1 + 0x1p-23f;
    Add(Distance(BsdfFormula(denser, wo, wi), middle), 1, change);
    Add(middle, FresnelChange(*TransmissionRatio(material), wo, wi), change);
  }
  if (WithoutCoat(material.kind) == BsdfKind::kRoughThinDielectric) {
    const double ratio = 1.0 / material.record.ior;
    const Vec mirrored = {wi.x, wi.y, std::fabs(wi.z)};
    Add(middle, FresnelChange(ratio, wo, mirrored), change);
    // What facets lose is the difference of two numbers near 1.
    for (const Vec& w : {wo, mirrored}) {
      Add(middle, 0x1p-24 / std::max(LostByGgx(double(material.record.alpha), w.z), 1e-6), change);
    }
  }
  if (material.kind == BsdfKind::kGlossyDiffuse) {
    const double ior = material.record.ior;
    Add(middle, FresnelChange(material.back ? ior : 1 / ior, wo, wi), change);
  }
  if (material.kind == BsdfKind::kPhong || material.kind == BsdfKind::kBlinn) {
    const double exponent = 2 / (double(material.record.alpha) * material.record.alpha) - 2;
    Add(middle, 0x1p-24 * 6 * exponent, change);
  }
  for (const Vec& axis : {Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}}) {
    FormulaValue most;
    for (const double step : {-moved, moved}) {
      const Vec o = Unit(wo + step * axis), i = Unit(wi + step * axis);
      most = Larger(most, Distance(BsdfFormula(material, o, wi), middle));
      most = Larger(most, Distance(BsdfFormula(material, wo, i), middle));
    }
    Add(most, 1, change);
  }
  return change;
}

}  // namespace skywave
