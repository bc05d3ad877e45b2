#include "tests/support/oracle_bsdf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/dielectric_tables.h"
#include "kernels/bsdf/pack.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/facet_quadrature.h"
#include "tests/support/glass_formulas.h"

namespace skywave {
namespace {

using glm::dvec3;

double Square(double x) { return x * x; }

// Returns the reflectance of a conductor: the index times the complex cosine inside is a + i b
// (Born and Wolf, 14.2). An index of 0 reflects everything.
double ConductorReflectance(double cosine, double eta, double k) {
  const double c = std::max(cosine, 1e-9), s2 = 1 - c * c, s_tan = s2 / c;
  const double real = eta * eta - k * k - s2;
  const double modulus = std::hypot(real, 2 * eta * k);
  const double a = std::sqrt(std::max(0.0, 0.5 * (modulus + real)));
  const double b2 = std::max(0.0, 0.5 * (modulus - real));
  const double perpendicular = (Square(a - c) + b2) / (Square(a + c) + b2);
  const double below = Square(a + s_tan) + b2;
  const double ratio = below > 0 ? (Square(a - s_tan) + b2) / below : 1;
  return 0.5 * perpendicular * (1 + ratio);
}
dvec3 ConductorReflectance(double cosine, const OracleMaterial& m) {
  if (m.eta == dvec3(0) && m.k == dvec3(0)) return dvec3(1);
  return {ConductorReflectance(cosine, m.eta.x, m.k.x),
          ConductorReflectance(cosine, m.eta.y, m.k.y),
          ConductorReflectance(cosine, m.eta.z, m.k.z)};
}

// Reads a table of width and cosine bilinearly in the square roots, as the engine does.
double TableAt(const float* table, double alpha, double cosine) {
  const double row = std::sqrt(alpha) * (kAlbedoRows - 1);
  const double column = std::sqrt(std::clamp(cosine, 0.0, 1.0)) * (kAlbedoColumns - 1);
  const int r = int(row), c = int(column);
  const float* e = table + r * int(kAlbedoColumns + 1) + c;
  const float* below = e + kAlbedoColumns + 1;
  const double fr = row - r, fc = column - c;
  return (1 - fr) * ((1 - fc) * e[0] + fc * e[1]) + fr * ((1 - fc) * below[0] + fc * below[1]);
}
// Returns E(cosine), the albedo of single scattering with F = 1.
double SingleScatterAlbedo(double alpha, double cosine) {
  return TableAt(GgxTables().albedo, alpha, cosine);
}

// Kulla and Conty 2017: the energy that single scattering loses, distributed reciprocally, with
// every further bounce darkened by the mean Fresnel reflectance.
dvec3 MultiscatterFactor(const OracleMaterial& m) {
  constexpr int kSteps = 2048;
  double albedo = 0;
  dvec3 fresnel(0);
  for (int i = 0; i < kSteps; ++i) {
    const double c = (i + 0.5) / kSteps;
    albedo += 2 * c / kSteps * SingleScatterAlbedo(m.alpha, c);
    fresnel += 2 * c / kSteps * ConductorReflectance(c, m);
  }
  const double lost = std::max(1 - albedo, 1e-6);
  return fresnel * fresnel * albedo / (1.0 - fresnel * lost) / (kPi * lost);
}

// Orthonormal axes about n.
struct Basis {
  explicit Basis(const dvec3& n) : z(n) {
    x = glm::normalize(glm::cross(std::fabs(n.x) > 0.7 ? dvec3(0, 1, 0) : dvec3(1, 0, 0), n));
    y = glm::cross(n, x);
  }
  Basis(const dvec3& n, const dvec3& tangent) : z(n) {
    x = glm::normalize(tangent - n * glm::dot(n, tangent));
    y = glm::cross(n, x);
  }
  dvec3 Local(const dvec3& w) const { return {glm::dot(x, w), glm::dot(y, w), glm::dot(z, w)}; }
  dvec3 World(const dvec3& w) const { return w.x * x + w.y * y + w.z * z; }
  dvec3 x, y, z;
};

dvec3 CosineDirection(OracleRandom& random) {
  const double radius2 = random(), turn = 2 * kPi * random();
  const double radius = std::sqrt(radius2);
  return {radius * std::cos(turn), radius * std::sin(turn), std::sqrt(1 - radius2)};
}

// Returns Smith's Lambda of GGX (Heitz 2014, eq. 72).
double Lambda(double alpha, const dvec3& w) {
  const double z2 = std::max(w.z * w.z, 1e-30);
  return 0.5 * (std::sqrt(1 + alpha * alpha * (w.x * w.x + w.y * w.y) / z2) - 1);
}

// Evaluates in the local frame: Walter et al. 2007 with height-correlated masking.
OracleValue EvaluateConductor(const OracleMaterial& m, const dvec3& wo, const dvec3& wi) {
  const dvec3 h = glm::normalize(wo + wi);
  const double a2 = m.alpha * m.alpha;
  const double d = a2 / (kPi * Square(a2 * h.z * h.z + h.x * h.x + h.y * h.y));
  const double lambda_o = Lambda(m.alpha, wo), lambda_i = Lambda(m.alpha, wi);
  const double lost_o = 1 - SingleScatterAlbedo(m.alpha, wo.z);
  const double lost_i = 1 - SingleScatterAlbedo(m.alpha, wi.z);
  const double over_4_cos = d / (4 * wo.z);
  const dvec3 single =
      over_4_cos / (1 + lambda_o + lambda_i) * ConductorReflectance(glm::dot(wo, h), m);
  const dvec3 multiple = lost_o * lost_i * wi.z * m.multiscatter;
  const double visible_normals = over_4_cos / (1 + lambda_o);
  return {m.reflectance * (single + multiple),
          (1 - lost_o) * visible_normals + lost_o * wi.z / kPi};
}

// Returns the albedo of the coat of a dielectric body.
double CoatAlbedo(const OracleMaterial& m, double cosine) {
  const double f0 = Square((m.ior - 1) / (m.ior + 1));
  return f0 * TableAt(GgxTables().albedo, m.alpha, cosine) +
         (1 - f0) * TableAt(GgxTables().grazing, m.alpha, cosine);
}

double SpecularShare(const OracleMaterial& m, double cosine) {
  const double gray = glm::dot(m.reflectance, dvec3(kLuminance[0], kLuminance[1], kLuminance[2]));
  const double f0 = glm::mix(Square((m.ior - 1) / (m.ior + 1)), gray, m.metallic);
  const double all = SingleScatterAlbedo(m.alpha, cosine);
  const double specular = f0 * all + (1 - f0) * TableAt(GgxTables().grazing, m.alpha, cosine);
  const double rest =
      gray * ((1 - m.metallic) * (1 - CoatAlbedo(m, cosine)) + m.metallic * (1 - all));
  return std::clamp(specular / (specular + rest), 0.1, 0.9);
}

// Evaluates kernels/bsdf/metallic_roughness-inl.h, its formulae in the order of their terms. The
// means over the hemisphere are integrated here.
OracleValue EvaluateMetallicRoughness(const OracleMaterial& m, const dvec3& wo, const dvec3& wi) {
  constexpr int kSteps = 64;
  double mean = 0, coat_mean = 0;
  for (int i = 0; i < kSteps; ++i) {
    // Shares are integrals of 4 s^3, because what facets lose may be a small rest.
    const double s = (i + 0.5) / kSteps;
    const double share = (std::pow(i + 1, 4) - std::pow(i, 4)) / std::pow(kSteps, 4);
    mean += share * SingleScatterAlbedo(m.alpha, s * s);
    coat_mean += share * CoatAlbedo(m, s * s);
  }
  const dvec3 h = glm::normalize(wo + wi);
  const double a2 = m.alpha * m.alpha;
  const double d = a2 / (kPi * Square(a2 * h.z * h.z + h.x * h.x + h.y * h.y));
  const double lambda_o = Lambda(m.alpha, wo), lambda_i = Lambda(m.alpha, wi);
  const double over_4_cos = d / (4 * wo.z);
  const dvec3 f0 = glm::mix(dvec3(Square((m.ior - 1) / (m.ior + 1))), m.reflectance, m.metallic);
  const dvec3 fresnel = f0 + (1.0 - f0) * std::pow(1 - std::min(glm::dot(wo, h), 1.0), 5);
  const dvec3 single = over_4_cos / (1 + lambda_o + lambda_i) * fresnel;
  const double through = (1 - CoatAlbedo(m, wo.z)) * (1 - CoatAlbedo(m, wi.z)) / (1 - coat_mean);
  const dvec3 body = (1 - m.metallic) * through / kPi * m.reflectance;
  const double lost = std::max(1 - mean, 1e-6);
  const dvec3 f = (20.0 * m.reflectance + 1.0) / 21.0;
  const dvec3 multiple = m.metallic * mean / (kPi * lost) * f * f / (1.0 - f * lost) *
                         (1 - SingleScatterAlbedo(m.alpha, wo.z)) *
                         (1 - SingleScatterAlbedo(m.alpha, wi.z));
  const double share = SpecularShare(m, wo.z);
  return {single + wi.z * (body + multiple),
          share * over_4_cos / (1 + lambda_o) + (1 - share) * wi.z / kPi};
}

// Draws a visible normal by the projected area of the stretched hemisphere (Heitz 2018, listing 1).
dvec3 VisibleNormal(double x_width, double y_width, const dvec3& wo, OracleRandom& random) {
  const dvec3 view = glm::normalize(dvec3(x_width * wo.x, y_width * wo.y, wo.z));
  const Basis basis(view);
  const double radius = std::sqrt(random()), turn = 2 * kPi * random();
  // basis.x is perpendicular to view; the half disk towards +z is compressed along the axis that
  // leans towards it.
  const dvec3 side =
      view.z < 0.9999999 ? glm::normalize(glm::cross(dvec3(0, 0, 1), view)) : basis.x;
  const dvec3 lean = glm::cross(view, side);
  const double t1 = radius * std::cos(turn), s = 0.5 * (1 + view.z);
  const double t2 = (1 - s) * std::sqrt(1 - t1 * t1) + s * radius * std::sin(turn);
  const dvec3 n = t1 * side + t2 * lean + std::sqrt(std::max(0.0, 1 - t1 * t1 - t2 * t2)) * view;
  return glm::normalize(dvec3(x_width * n.x, y_width * n.y, std::max(1e-9, n.z)));
}
dvec3 VisibleNormal(double alpha, const dvec3& wo, OracleRandom& random) {
  return VisibleNormal(alpha, alpha, wo, random);
}

OracleValue EvaluateRough(const OracleMaterial& m, const dvec3& wo, const dvec3& wi) {
  return m.bsdf == BsdfKind::kConductor ? EvaluateConductor(m, wo, wi)
                                        : EvaluateMetallicRoughness(m, wo, wi);
}
double SpecularProbability(const OracleMaterial& m, double cosine) {
  return m.bsdf == BsdfKind::kConductor ? SingleScatterAlbedo(m.alpha, cosine)
                                        : SpecularShare(m, cosine);
}

// BSDFs with formulae are drawn by lobes of which none has to fit: their densities are known.
bool Transmits(const OracleMaterial& m) { return Bsdfs()[std::size_t(m.bsdf)].transmits; }
double VisibleDensity(double alpha, const dvec3& wo, const dvec3& wi) {
  const dvec3 h = glm::normalize(wo + wi);
  const double a2 = alpha * alpha;
  const double d = a2 / (kPi * Square(a2 * h.z * h.z + h.x * h.x + h.y * h.y));
  return d / (4 * wo.z * (1 + Lambda(alpha, wo)));
}
bool Refracts(const OracleMaterial& m) { return Bsdfs()[std::size_t(m.bsdf)].refracts; }
// The lobe of the coat of glass, which is drawn with this probability.
struct CoatLobe {
  double share, alpha;
};
CoatLobe CoatLobeOf(const OracleMaterial& m) {
  if (m.bsdf != BsdfKind::kCoatedRoughDielectric) return {0, 1};
  return {0.2, CoatOfGlass(m.formula->record).alpha};
}
// Returns the widths of lobes about the mirror direction.
std::array<double, 2> LobeWidths(const OracleMaterial& m) {
  return {std::max(LobeWidth(*m.formula), 0.02), std::max(m.alpha, 0.1)};
}

OracleValue EvaluateFormula(const OracleMaterial& m, bool back, const dvec3& wo, const dvec3& wi) {
  const FormulaValue exact =
      BsdfFormula(back ? *m.formula_of_back : *m.formula, {wo.x, wo.y, wo.z}, {wi.x, wi.y, wi.z});
  OracleValue out = {{exact.rgb[0], exact.rgb[1], exact.rgb[2]}, exact.pdf};
  if (Refracts(m)) {
    const double facets = FacetDensityOfGlass(back ? *m.formula_of_back : *m.formula,
                                              {wo.x, wo.y, wo.z}, {wi.x, wi.y, wi.z});
    const double below = 0.7 * facets + 0.3 * std::abs(wi.z) / (2 * kPi);
    const CoatLobe coat = CoatLobeOf(m);
    out.pdf = std::lerp(below, wi.z > 0 ? VisibleDensity(coat.alpha, wo, wi) : 0, coat.share);
    return out;
  }
  const dvec3 up(wi.x, wi.y, std::abs(wi.z));
  out.pdf = up.z / kPi;
  if (m.bsdf != BsdfKind::kDiffuseTransmission) {
    for (const double width : LobeWidths(m)) out.pdf += VisibleDensity(width, wo, up);
    out.pdf /= 3;
  }
  if (Transmits(m)) out.pdf /= 2;  // both sides have the same density
  return out;
}

dvec3 DrawFormula(const OracleMaterial& m, bool back, const dvec3& wo, OracleRandom& random) {
  if (m.bsdf == BsdfKind::kDiffuseTransmission) {
    const dvec3 up = CosineDirection(random);
    return random() < 0.5 ? up : -up;
  }
  if (Refracts(m)) {
    if (const CoatLobe coat = CoatLobeOf(m); random() < coat.share) {
      const dvec3 h = VisibleNormal(coat.alpha, wo, random);
      const dvec3 wi = 2 * glm::dot(wo, h) * h - wo;
      return wi.z > 0 ? wi : dvec3(0);
    }
    // Three in ten are drawn for the light that scatters between facets.
    if (random() < 0.3) return random() < 0.5 ? CosineDirection(random) : -CosineDirection(random);
    const dvec3 h = VisibleNormal(m.alpha, m.alpha_across, wo, random);
    const double c = std::min(glm::dot(wo, h), 1.0), ratio = back ? m.ior : 1 / m.ior;
    const double sine2 = ratio * ratio * (1 - c * c), inside = std::sqrt(std::max(0.0, 1 - sine2));
    const double across = (ratio * c - inside) / (ratio * c + inside);
    const double along = (c - ratio * inside) / (c + ratio * inside);
    const double reflectance = sine2 >= 1 ? 1 : 0.5 * (Square(across) + Square(along));
    if (random() < reflectance) return 2 * c * h - wo;
    return ratio * (c * h - wo) - inside * h;
  }
  const double lobe = 3 * random();
  if (lobe < 1 && !Transmits(m)) return CosineDirection(random);
  if (lobe < 1) return random() < 0.5 ? CosineDirection(random) : -CosineDirection(random);
  const dvec3 h = VisibleNormal(LobeWidths(m)[lobe < 2 ? 0 : 1], wo, random);
  const dvec3 wi = 2 * glm::dot(wo, h) * h - wo;
  if (!(wi.z > 0)) return dvec3(0);  // into the surface: no density counts it
  return Transmits(m) && random() < 0.5 ? dvec3(wi.x, wi.y, -wi.z) : wi;
}

OracleScatter ScatterFormula(const OracleSurface& s, const Basis& basis, OracleRandom& random) {
  const OracleMaterial& m = *s.material;
  const dvec3 wo = basis.Local(s.wo), wi = DrawFormula(m, s.back, wo, random);
  OracleScatter out;
  out.wi = basis.World(wi);
  const double side = glm::dot(s.ng, out.wi);
  if (!(wi.z * side > 0) || (wi.z < 0 && !Transmits(m))) return out;
  const OracleValue value = EvaluateFormula(m, s.back, wo, wi);
  if (!(value.pdf > 0)) return out;
  out.weight = value.value / value.pdf, out.pdf = value.pdf;
  out.alive = true;
  return out;
}

// Returns the table of kernels/bsdf/dielectric_tables.h, by another quadrature (KeptByFacets).
DielectricTable LossesByQuadrature(double x_width, double y_width, double ior) {
  constexpr int kRadii = 200, kTurns = 64, kHeights = 64, kAzimuths = 8;
  const auto lost = [&](bool inside, double mu, double azimuth) {
    const double ratio = inside ? ior : 1 / ior, sine = std::sqrt(1 - mu * mu);
    const dvec3 wo(sine * std::cos(azimuth), sine * std::sin(azimuth), mu);
    return std::max(0.0, 1 - KeptByFacets(x_width, y_width, wo, ratio, kRadii, kTurns));
  };
  // With two widths, the rows are azimuths by |y| / (|x| + |y|).
  const int azimuths = x_width == y_width ? 1 : kAzimuths;
  DielectricTable table;
  for (const bool inside : {false, true}) {
    for (std::size_t column = 0; column < kSideColumns; ++column) {
      const double root = std::min(double(column) / (kAlbedoColumns - 1), 1.0);
      std::vector<double> of_azimuth;
      for (int a = 0; a <= azimuths; ++a) {
        const double share = double(a) / azimuths;
        of_azimuth.push_back(
            lost(inside, std::max(root * root, 1e-4), std::atan2(share, 1 - share)));
      }
      for (std::size_t r = 0; r <= kAlbedoRows; ++r) {
        const double at = std::min(double(r) / (kAlbedoRows - 1), 1.0) * azimuths;
        const std::size_t low = std::min(std::size_t(at), std::size_t(azimuths - 1));
        table.rows[r].lost[inside][column] =
            float(std::lerp(of_azimuth[low], of_azimuth[low + 1], at - double(low)));
      }
    }
    double mean = 0;
    for (int i = 0; i < kHeights; ++i) {
      const double s = (i + 0.5) / kHeights;
      for (int a = 0; a < azimuths; ++a) {
        const double azimuth = kPi / 2 * (a + 0.5) / azimuths;
        mean += 4 * s * s * s / (kHeights * azimuths) * lost(inside, s * s, azimuth);
      }
    }
    for (DielectricRow& row : table.rows) row.mean[inside] = float(mean);
  }
  return table;
}

Basis BasisOf(const OracleSurface& s) {
  return s.tangent == dvec3(0) ? Basis(s.ns) : Basis(s.ns, s.tangent);
}

// Returns the normal about which a delta BSDF acts: the shading normal unless its reflection enters
// the surface.
dvec3 DeltaNormal(const OracleSurface& s) {
  const dvec3 reflected = 2 * glm::dot(s.ns, s.wo) * s.ns - s.wo;
  return glm::dot(reflected, s.ng) > 0 ? s.ns : s.ng;
}

OracleScatter ScatterMirror(const OracleSurface& s) {
  const dvec3 n = DeltaNormal(s);
  const double cosine = glm::dot(n, s.wo);
  const dvec3 wi = 2 * cosine * n - s.wo;
  return {wi, s.material->reflectance * ConductorReflectance(std::min(cosine, 1.0), *s.material), 0,
          glm::dot(s.ng, wi) > 0};
}

OracleScatter ScatterGlass(const OracleSurface& s, OracleRandom& random) {
  const OracleMaterial& m = *s.material;
  const dvec3 n = DeltaNormal(s);
  const bool thin = m.bsdf == BsdfKind::kThinDielectric;
  const bool inside = s.back && !thin;
  const double near = inside ? m.ior : 1, far = inside ? 1 : m.ior;
  const double c = std::clamp(glm::dot(n, s.wo), 0.0, 1.0);
  const double sine_inside = near / far * std::sqrt(1 - c * c);
  double reflectance = 1, cosine_inside = 0;
  if (sine_inside < 1) {
    cosine_inside = std::sqrt(1 - sine_inside * sine_inside);
    const double perpendicular =
        (near * c - far * cosine_inside) / (near * c + far * cosine_inside);
    const double parallel = (far * c - near * cosine_inside) / (far * c + near * cosine_inside);
    reflectance = 0.5 * (Square(perpendicular) + Square(parallel));
  }
  // Between its two sides, a pane reflects R + T^2 R + T^2 R^3 and so on.
  if (thin) {
    const double through = 1 - reflectance;
    reflectance += through * through * reflectance / (1 - reflectance * reflectance);
  }
  if (random() < reflectance) {
    const dvec3 wi = 2 * c * n - s.wo;
    return {wi, m.reflectance, 0, glm::dot(s.ng, wi) > 0};
  }
  if (thin) return {-s.wo, m.reflectance, 0, glm::dot(s.ng, -s.wo) < 0};
  // By Snell's law, the tangential part is scaled by the ratio of the indices. Radiance spreads
  // over a wider cone on the side of the smaller index.
  const dvec3 wi = glm::normalize(near / far * (c * n - s.wo) - cosine_inside * n);
  return {wi, m.reflectance * Square(near / far), 0, glm::dot(s.ng, wi) < 0};
}

}  // namespace

OracleMaterial MakeOracleMaterial(const Material& material) {
  using enum BsdfKind;
  const std::string name(Bsdfs()[std::size_t(material.bsdf)].name);
  if (material.bsdf == kMeasured || material.mixture || material.absorption != glm::vec3(0)) {
    throw std::logic_error("the oracle knows no measured, mixed or absorbing material: " + name);
  }
  const bool own = material.bsdf == kLambert || material.bsdf == kConductor ||
                   material.bsdf == kMetallicRoughness ||
                   std::uint32_t(material.bsdf) >= kFirstDeltaBsdf;
  if (!own && (material.color_texture || material.roughness_texture)) {
    throw std::logic_error("the oracle knows no textures of " + name);
  }
  OracleMaterial m = {
      .bsdf = material.bsdf,
      .reflectance = material.reflectance,
      .eta = material.eta,
      .k = material.k,
      .alpha = std::clamp(double(material.alpha), 1e-3, 1.0),
      .alpha_across = std::clamp(double(material.alpha_across.value_or(material.alpha)), 1e-3, 1.0),
      .ior = material.ior,
      .metallic = material.metallic,
      .multiscatter = dvec3(0)};
  if (m.bsdf == kConductor && material.energy_compensation) m.multiscatter = MultiscatterFactor(m);
  if (!own) {
    const bool coated = material.bsdf == kCoatedConductor || material.bsdf == kCoatedDiffuse;
    MaterialCase packed = {name, material.bsdf,
                           coated ? RecordWithCoat(material) : PackMaterial(material, {})};
    if (Refracts(m) && material.energy_compensation) {
      packed.record = RecordOfGlass(material, LossesByQuadrature(m.alpha, m.alpha_across, m.ior));
    }
    m.formula = std::make_shared<MaterialCase>(packed);
    packed.back = true;
    m.formula_of_back = std::make_shared<MaterialCase>(packed);
    if (!BsdfFormula(*m.formula, {0, 0, 1}, {0, 0.6, 0.8}).known) {
      throw std::logic_error("the oracle does not know " + name);
    }
  }
  return m;
}

OracleValue EvaluateBsdf(const OracleSurface& s, const dvec3& wi) {
  const double cosine = glm::dot(s.ns, wi);
  if (s.material->formula && cosine * glm::dot(s.ng, wi) > 0 &&
      (cosine > 0 || Transmits(*s.material))) {
    const Basis basis = BasisOf(s);
    return EvaluateFormula(*s.material, s.back, basis.Local(s.wo), basis.Local(wi));
  }
  if (!(cosine > 0) || !(glm::dot(s.ng, wi) > 0)) return {dvec3(0), 0};
  if (s.material->bsdf == BsdfKind::kLambert) {
    return {s.material->reflectance * cosine / kPi, cosine / kPi};
  }
  const Basis basis(s.ns);
  return EvaluateRough(*s.material, basis.Local(s.wo), basis.Local(wi));
}

OracleScatter ScatterBsdf(const OracleSurface& s, OracleRandom& random) {
  const OracleMaterial& m = *s.material;
  if (m.bsdf == BsdfKind::kMirror) return ScatterMirror(s);
  if (m.delta()) return ScatterGlass(s, random);
  if (m.formula) return ScatterFormula(s, BasisOf(s), random);
  const Basis basis(s.ns);
  const dvec3 wo = basis.Local(s.wo);
  OracleScatter out;
  dvec3 local;
  if (m.bsdf == BsdfKind::kLambert || random() >= SpecularProbability(m, wo.z)) {
    local = CosineDirection(random);
  } else {
    const dvec3 h = VisibleNormal(m.alpha, wo, random);
    local = 2 * glm::dot(wo, h) * h - wo;
  }
  out.wi = basis.World(local);
  if (!(local.z > 0) || !(glm::dot(s.ng, out.wi) > 0)) return out;
  if (m.bsdf == BsdfKind::kLambert) {
    out.weight = m.reflectance, out.pdf = local.z / kPi;
  } else {
    const OracleValue value = EvaluateRough(m, wo, local);
    if (!(value.pdf > 0)) return out;
    out.weight = value.value / value.pdf, out.pdf = value.pdf;
  }
  out.alive = true;
  return out;
}

}  // namespace skywave
