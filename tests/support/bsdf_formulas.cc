#include "tests/support/bsdf_formulas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <utility>

#include "kernels/bsdf/coat_tables.h"
#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/dielectric_tables.h"
#include "kernels/bsdf/material.h"
#include "tests/support/facet_formulas.h"
#include "tests/support/glass_formulas.h"
#include "tests/support/glossy_formulas.h"
#include "tests/support/layered_formulas.h"
#include "tests/support/oracle_bsdf.h"

namespace skywave {
namespace {

// The equations are those of the abstract model of Portsmouth et al. 2025.
FormulaValue OrenNayarFormula(const MaterialRecord& m, Vec wo, Vec wi) {
  const double r = m.alpha;
  const double a = 1 / (1 + (0.5 - 2 / (3 * kPi)) * r);
  const auto albedo = [&](double mu) {
    const double theta = std::acos(mu), s = std::sin(theta);
    const double g = s * (theta - s * mu) + 2.0 / 3 * (s / mu * (1 - s * s * s) - s);
    return a + r * a / kPi * g;
  };
  const double mean = a * (1 + r * (2.0 / 3 - 28 / (15 * kPi)));
  const double s = Dot(wo, wi) - wo.z * wi.z;
  const double bent = s > 0 ? s / std::max(wo.z, wi.z) : s;
  FormulaValue out;
  out.pdf = wi.z / kPi;
  for (int c = 0; c < 3; ++c) {
    const double rho = m.color[c];
    const double again = rho * rho * mean / (1 - rho * (1 - mean));
    out.rgb[c] =
        wi.z / kPi *
        (rho * a * (1 + r * bent) + again * (1 - albedo(wo.z)) * (1 - albedo(wi.z)) / (1 - mean));
  }
  if (r == 0) {
    for (int c = 0; c < 3; ++c) out.rgb[c] = m.color[c] * wi.z / kPi;
  }
  return out;
}

FormulaValue DiffuseTransmissionFormula(const MaterialRecord& m, Vec wi) {
  const double back = std::max({m.color[0], m.color[1], m.color[2]});
  const double through = std::max({m.eta[0], m.eta[1], m.eta[2]});
  FormulaValue out;
  const double share = (wi.z > 0 ? back : through) / (back + through);
  out.pdf = share * std::fabs(wi.z) / kPi;
  for (int c = 0; c < 3; ++c) {
    out.rgb[c] = (wi.z > 0 ? m.color : m.eta)[c] * std::fabs(wi.z) / kPi;
  }
  return out;
}

}  // namespace

double TableAt(const float* table, double alpha, double cosine) {
  const double r = std::sqrt(alpha) * (kAlbedoRows - 1);
  const double c = std::sqrt(std::clamp(cosine, 0.0, 1.0)) * (kAlbedoColumns - 1);
  const auto row = std::min(std::size_t(r), std::size_t(kAlbedoRows - 1));
  const auto column = std::size_t(c);
  const auto at = [&](std::size_t i, std::size_t j) {
    return double(table[i * (kAlbedoColumns + 1) + j]);
  };
  const double above = std::lerp(at(row, column), at(row, column + 1), c - double(column));
  const double below = std::lerp(at(row + 1, column), at(row + 1, column + 1), c - double(column));
  return std::lerp(above, below, r - double(row));
}

double MeanAt(const float* table, double alpha) {
  const double row = std::sqrt(alpha) * (kAlbedoRows - 1);
  const auto low = std::min(std::size_t(row), std::size_t(kAlbedoRows - 1));
  return std::lerp(double(table[low]), double(table[low + 1]), row - double(low));
}

namespace {

// A coat of Schlick's reflectance over a body that lets through everything that the coat does.
FormulaValue CoatedDiffuseTransmissionFormula(const MaterialRecord& m, Vec wo, Vec wi) {
  const double f0 = Square((m.ior - 1.0) / (m.ior + 1.0));
  const auto through = [&](double cosine) {
    return 1 - std::lerp(TableAt(GgxTables().grazing, m.alpha, std::fabs(cosine)),
                         TableAt(GgxTables().albedo, m.alpha, std::fabs(cosine)), f0);
  };
  const double mean = 1 - std::lerp(MeanAt(GgxTables().mean_grazing, m.alpha),
                                    MeanAt(GgxTables().padded_mean_albedo, m.alpha), f0);
  const double coat = 1 - through(wo.z), rest = through(wo.z) * LuminanceOf(m.color);
  const double share = std::clamp(coat / (coat + rest), 0.1, 0.9);
  FormulaValue out;
  if (wi.z > 0) {
    const Vec h = HalfOf(wo, wi);
    const double lobe = GgxDensity(h, m.alpha, m.alpha) / (4 * wo.z);
    const double lo = GgxLambda(wo, m.alpha, m.alpha), li = GgxLambda(wi, m.alpha, m.alpha);
    const double fresnel = f0 + (1 - f0) * Power5(1 - std::min(Dot(wo, h), 1.0));
    for (double& c : out.rgb) c = fresnel * lobe / (1 + lo + li);
    out.pdf = share * lobe / (1 + lo);
  } else {
    const double cosine = std::fabs(wi.z) / kPi;
    for (int c = 0; c < 3; ++c) {
      out.rgb[c] = m.color[c] * through(wo.z) * through(wi.z) / mean * cosine;
    }
    out.pdf = (1 - share) * cosine;
  }
  return out;
}

}  // namespace

double AnisotropicAlbedoAt(double along, double across, Vec w) {
  const AnisotropicTables& tables = GetAnisotropicTables();
  const double places[4] = {
      std::sqrt(along) * (kTabledWidths - 1), std::sqrt(across) * (kTabledWidths - 1),
      std::sqrt(w.z) * (kTabledCosines - 1),
      std::fabs(w.y) / std::max(std::fabs(w.x) + std::fabs(w.y), 1e-30) * (kTabledAzimuths - 1)};
  const std::size_t counts[4] = {kTabledWidths, kTabledWidths, kTabledCosines, kTabledAzimuths};
  double sum = 0;
  for (std::size_t corner = 0; corner < 16; ++corner) {
    double weight = 1;
    std::size_t at[4];
    for (std::size_t d = 0; d < 4; ++d) {
      const std::size_t low = std::min(std::size_t(places[d]), counts[d] - 2);
      const std::size_t step = corner >> d & 1;
      at[d] = low + step;
      const double share = places[d] - double(low);
      weight *= step == 1 ? share : 1 - share;
    }
    sum += weight * double(tables.albedo[at[0]][at[1]][at[2]][at[3]]);
  }
  return sum;
}

namespace {

FormulaValue ConductorFormula(const MaterialCase& material, Vec wo, Vec wi) {
  const MaterialRecord& m = material.record;
  const bool gauss = material.kind == BsdfKind::kBeckmannConductor;
  const double x = m.alpha, y = m.ior;
  const auto lambda = gauss ? BeckmannLambda : GgxLambda;
  const Vec h = HalfOf(wo, wi);
  const double d = gauss ? BeckmannDensity(h, x, y) : GgxDensity(h, x, y);
  const double lo = lambda(wo, x, y), li = lambda(wi, x, y);
  FormulaValue out;
  out.pdf = d / (4 * wo.z * (1 + lo));
  for (int c = 0; c < 3; ++c) {
    const double f = FresnelReflectance(std::min(1.0, Dot(wo, h)), {m.eta[c], m.k[c]});
    out.rgb[c] = m.color[c] * f * d / (4 * wo.z * (1 + lo + li));
  }
  if (gauss || m.multiscatter[0] == 0) return out;
  const double lost_o = 1 - AnisotropicAlbedoAt(x, y, wo);
  const double lost_i = 1 - AnisotropicAlbedoAt(x, y, wi);
  for (int c = 0; c < 3; ++c) {
    out.rgb[c] += m.color[c] * double(m.multiscatter[c]) * lost_o * lost_i * wi.z;
  }
  out.pdf = (1 - lost_o) * out.pdf + lost_o * wi.z / kPi;
  return out;
}

// Adds one layer of kernels/bsdf/coat-inl.h over `below`.
FormulaValue LayerOver(const FormulaValue& below, const double (&own)[3], double own_pdf,
                       double albedo_o, double albedo_i) {
  const double half = 0.5 * (1 - albedo_o);
  const double share = albedo_o > 0 ? std::clamp(albedo_o / (albedo_o + half), 0.1, 0.9) : 0.0;
  FormulaValue out;
  out.pdf = share * own_pdf + (1 - share) * below.pdf;
  for (int c = 0; c < 3; ++c) {
    out.rgb[c] = own[c] + (1 - std::max(albedo_o, albedo_i)) * below.rgb[c];
  }
  return out;
}

FormulaValue CoatFormula(const FormulaValue& below, double strength, double alpha, double f0,
                         Vec wo, Vec wi) {
  const auto albedo = [&](double cosine) {
    return strength * (f0 * TableAt(GgxTables().albedo, alpha, cosine) +
                       (1 - f0) * TableAt(GgxTables().grazing, alpha, cosine));
  };
  const Vec up = {wi.x, wi.y, std::fabs(wi.z)}, h = HalfOf(wo, up);
  const double fresnel = strength * (f0 + (1 - f0) * std::pow(1 - std::min(1.0, Dot(wo, h)), 5));
  const double lobe = wi.z > 0 ? GgxDensity(h, alpha, alpha) / (4 * wo.z) : 0;
  const double lo = GgxLambda(wo, alpha, alpha), li = GgxLambda(up, alpha, alpha);
  const double value = fresnel * lobe / (1 + lo + li);
  return LayerOver(below, {value, value, value}, lobe / (1 + lo), albedo(wo.z), albedo(up.z));
}

double ColumnAt(const CoatColumn& column, double cosine) {
  const double at = std::sqrt(std::clamp(cosine, 0.0, 1.0)) * (kAlbedoColumns - 1);
  const auto low = std::min(std::size_t(at), std::size_t(kAlbedoColumns - 1));
  return std::lerp(double(column[low]), double(column[low + 1]), at - double(low));
}

// The formulae of kernels/bsdf/coat_tables.h, with the tables of the record.
FormulaValue TabledCoatFormula(const MaterialCase& material, Vec wo, Vec wi) {
  const MaterialRecord& m = material.record;
  const bool metal = material.kind == BsdfKind::kCoatedConductor;
  const CoatTable& table = CoatsForTests()[std::bit_cast<std::uint32_t>(m.multiscatter[0])];
  const double ior = m.ior;
  FormulaValue below;
  below.pdf = wi.z / kPi;
  double lobe = 1;
  Vec h = {0, 0, 1}, o = h;
  if (metal) {
    const auto inside = [&](Vec w) {
      const double x = w.x / ior, y = w.y / ior;
      return Vec{x, y, std::sqrt(1 - x * x - y * y)};
    };
    o = inside(wo);
    const Vec i = inside(wi);
    h = HalfOf(o, i);
    const double lo = GgxLambda(o, m.alpha, m.alpha), li = GgxLambda(i, m.alpha, m.alpha);
    const double d = GgxDensity(h, m.alpha, m.alpha) / (4 * o.z) * wi.z / (ior * ior * i.z);
    below.pdf = d / (1 + lo);
    lobe = d / (1 + lo + li);
  }
  for (int c = 0; c < 3; ++c) {
    const double both = ColumnAt(table.through[c], wo.z) * ColumnAt(table.through[c], wi.z);
    const double medium = ColumnAt(table.medium[c], wo.z) * ColumnAt(table.medium[c], wi.z) * wi.z;
    const double body =
        metal ? m.color[c] * lobe * FresnelReflectance(std::min(1.0, Dot(o, h)), {m.eta[c], m.k[c]})
              : m.color[c] / (1 - m.color[c] * double(table.returned[c])) * wi.z;
    below.rgb[c] = body * both + medium;
  }
  const double alpha = metal ? m.multiscatter[1] : m.alpha;
  const Vec up = HalfOf(wo, wi);
  const double own = GgxDensity(up, alpha, alpha) / (4 * wo.z);
  const double lo = GgxLambda(wo, alpha, alpha), li = GgxLambda(wi, alpha, alpha);
  const double value = RealFresnel(std::min(1.0, Dot(wo, up)), 1 / ior) * own / (1 + lo + li);
  const double albedo = ColumnAt(table.own, wo.z);
  // LayerOver takes from below what the layer reflects, and here that is in the tables.
  const double half = 0.5 * (1 - albedo), share = std::clamp(albedo / (albedo + half), 0.1, 0.9);
  FormulaValue out;
  out.pdf = share * own / (1 + lo) + (1 - share) * below.pdf;
  for (int c = 0; c < 3; ++c) out.rgb[c] = value + below.rgb[c];
  return out;
}

FormulaValue SheenFormula(const FormulaValue& below, const MaterialRecord& m, Vec wo, Vec wi) {
  const double alpha = m.k[2], power = 1 / alpha;
  const Vec h = HalfOf(wo, wi);
  const double d = (2 + power) / (2 * kPi) * std::pow(std::hypot(h.x, h.y), power);
  const double visible = 1 / (4 * (wo.z + wi.z - wo.z * wi.z));
  const double row = std::sqrt(alpha) * (kAlbedoRows - 1);
  const float* scale = GetSheenTables().scale + std::size_t(row);
  const double lobe = d * visible * wi.z * std::lerp(scale[0], scale[1], row - std::floor(row));
  const double largest = std::max({m.multiscatter[0], m.multiscatter[1], m.multiscatter[2]});
  const auto albedo = [&](double cosine) {
    return largest * TableAt(GetSheenTables().albedo, alpha, cosine);
  };
  return LayerOver(below,
                   {lobe * m.multiscatter[0], lobe * m.multiscatter[1], lobe * m.multiscatter[2]},
                   wi.z / kPi, albedo(wo.z), albedo(wi.z));
}

// These BSDFs exist in the oracle; layers lie over two of them.
FormulaValue BaseFormula(BsdfKind base, const MaterialRecord& m, Vec wo, Vec wi) {
  const glm::dvec3 up(0, 0, 1), o(wo.x, wo.y, wo.z), i(wi.x, wi.y, wi.z);
  // Building a material integrates the scattering of facets, so the last one is cached.
  static std::optional<std::pair<BsdfKind, MaterialRecord>> last;
  static OracleMaterial exact;
  if (!last || last->first != base || WordsOf(last->second) != WordsOf(m)) {
    last = {base, m};
    exact = MakeOracleMaterial({.bsdf = base,
                                .reflectance = {m.color[0], m.color[1], m.color[2]},
                                .eta = {m.eta[0], m.eta[1], m.eta[2]},
                                .k = {m.k[0], m.k[1], m.k[2]},
                                .alpha = m.alpha,
                                .ior = m.ior,
                                .metallic = m.eta[0]});
  }
  const OracleValue value = EvaluateBsdf({&exact, o, up, up, false}, i);
  return {{value.value.x, value.value.y, value.value.z}, value.pdf};
}

// Computes the coordinates of the MERL database by rotations, as its readers do.
FormulaValue MeasuredFormula(const MaterialRecord& m, Vec wo, Vec wi) {
  const Vec h = HalfOf(wo, wi);
  const double theta = std::acos(std::min(h.z, 1.0)), phi = std::atan2(h.y, h.x);
  const Vec turned = {std::cos(phi) * wi.x + std::sin(phi) * wi.y,
                      std::cos(phi) * wi.y - std::sin(phi) * wi.x, wi.z};
  const Vec d = {std::cos(theta) * turned.x - std::sin(theta) * turned.z, turned.y,
                 std::sin(theta) * turned.x + std::cos(theta) * turned.z};
  double azimuth = std::atan2(d.y, d.x);
  if (azimuth < 0) azimuth += kPi;
  const double at[3] = {std::sqrt(theta / (kPi / 2)) * kMeasuredHalf,
                        std::acos(std::min(d.z, 1.0)) / (kPi / 2) * kMeasuredDifference,
                        azimuth / kPi * kMeasuredTurn};
  FormulaValue out;
  // Next to the border of a bin, either neighbour is right.
  for (const double x : at) out.known = out.known && std::fabs(x - std::round(x)) > 1e-3;
  const auto bin = [](double x, std::uint32_t bins) {
    return std::min(std::size_t(x), std::size_t(bins - 1));
  };
  const std::size_t index =
      (bin(at[0], kMeasuredHalf) * kMeasuredDifference + bin(at[1], kMeasuredDifference)) *
          kMeasuredTurn +
      bin(at[2], kMeasuredTurn);
  const float* const table = MeasuredForTests();
  for (std::size_t c = 0; c < 3; ++c) {
    out.rgb[c] = m.color[c] * double(table[3 * index + c]) * wi.z;
  }
  const double visible =
      GgxDensity(h, m.alpha, m.alpha) / (4 * wo.z) / (1 + GgxLambda(wo, m.alpha, m.alpha));
  out.pdf = m.ior * visible + (1 - m.ior) * wi.z / kPi;
  return out;
}

// Turns a direction about the axis that is at right angles to both normals, as far as the coat's is
// from that of the base, which looks at wo at least at a grazing angle.
Vec BelowCoat(const MaterialCase& material, Vec wo, Vec w) {
  if (!IsTilted(material)) return w;
  const double missing = std::max(1.0 / 128 - Dot(material.base_normal, wo), 0.0);
  const Vec normal = Unit(material.base_normal + missing * wo);
  const Vec axis = Unit(Cross(normal, {0, 0, 1}));
  const double c = normal.z, s = std::sqrt(1 - c * c);
  return c * w + s * Cross(axis, w) + (1 - c) * Dot(axis, w) * axis;
}

}  // namespace

double LostByGgx(double alpha, double cosine) {
  return 1 - TableAt(GgxTables().albedo, alpha, cosine);
}

FormulaValue BsdfFormula(const MaterialCase& material, Vec wo, Vec wi) {
  const MaterialRecord& m = material.record;
  switch (material.kind) {
    case BsdfKind::kLambert:
    case BsdfKind::kConductor:
    case BsdfKind::kMetallicRoughness:
      return BaseFormula(material.kind, m, wo, wi);
    case BsdfKind::kOrenNayar:
      return OrenNayarFormula(m, wo, wi);
    case BsdfKind::kDiffuseTransmission:
      return DiffuseTransmissionFormula(m, wi);
    case BsdfKind::kRoughDielectric:
      return RoughDielectricFormula(material, wo, wi);
    case BsdfKind::kAnisotropicConductor:
    case BsdfKind::kBeckmannConductor:
      return ConductorFormula(material, wo, wi);
    case BsdfKind::kPhong:
      return PhongFormula(m, wo, wi);
    case BsdfKind::kBlinn:
      return BlinnFormula(m, wo, wi);
    case BsdfKind::kWard:
      return WardFormula(m, wo, wi);
    case BsdfKind::kCoatedMetallicRoughness:
      return CoatFormula(
          SheenFormula(BaseFormula(BsdfKind::kMetallicRoughness, m, wo, wi), m, wo, wi), m.k[0],
          m.k[1], 0.04, wo, wi);
    case BsdfKind::kLayeredMetallicRoughness: {
      const MaterialRecord here = LayersAtHit(material);
      const Vec below_o = BelowCoat(material, wo, wo), below_i = BelowCoat(material, wo, wi);
      FormulaValue base;  // nothing where the base sees one of the directions from behind
      if (std::min(below_o.z, below_i.z) > 0) {
        base = SheenFormula(LayeredBaseFormula(material, below_o, below_i), here, below_o, below_i);
      }
      return CoatFormula(base, here.k[0], here.k[1], 0.04, wo, wi);
    }
    case BsdfKind::kCoatedRoughDielectric:
    case BsdfKind::kCoatedRoughThinDielectric: {
      const Vec below_o = BelowCoat(material, wo, wo), below_i = BelowCoat(material, wo, wi);
      FormulaValue glass;  // nothing where it sees one of the directions from another side
      if (below_o.z > 0 && below_i.z * wi.z > 0) {
        glass = material.kind == BsdfKind::kCoatedRoughDielectric
                    ? RoughDielectricFormula(material, below_o, below_i)
                    : RoughThinDielectricFormula(material, below_o, below_i);
      }
      const GlassCoatWords coat = CoatOfGlass(m);
      return CoatFormula(glass, coat.strength, coat.alpha, 0.04, wo, wi);
    }
    case BsdfKind::kCoatedConductor:
    case BsdfKind::kCoatedDiffuse:
      return TabledCoatFormula(material, wo, wi);
    case BsdfKind::kCoatedDiffuseTransmission:
      return CoatedDiffuseTransmissionFormula(m, wo, wi);
    case BsdfKind::kRoughThinDielectric:
      return RoughThinDielectricFormula(material, wo, wi);
    case BsdfKind::kGlossyDiffuse:
      return GlossyDiffuseFormula(material, wo, wi);
    case BsdfKind::kFresnelBlend:
      return FresnelBlendFormula(m, wo, wi);
    case BsdfKind::kMeasured:
      return MeasuredFormula(m, wo, wi);
    default:
      return {.known = false};
  }
}

}  // namespace skywave
