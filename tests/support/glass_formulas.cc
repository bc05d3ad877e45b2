#include "tests/support/glass_formulas.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <map>

#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/dielectric_tables.h"
#include "tests/support/facet_formulas.h"
#include "tests/support/layered_formulas.h"

namespace skywave {
namespace {

// What glass reflects has a colour of its own where the material gives one.
const float* GlassColor(const MaterialRecord& m, bool reflects) {
  return reflects && m.eta[0] > 0 ? m.eta : m.color;
}

// The equations are Walter et al. 2007, eqs. 20 and 21, in the original terms: the indices of both
// sides.
FormulaValue GlassFacetsFormula(const MaterialCase& material, Vec wo, Vec wi) {
  const MaterialRecord& m = material.record;
  const double near = material.back ? m.ior : 1, far = material.back ? 1 : m.ior;
  const double x = m.alpha, y = m.multiscatter[2] > 0 ? m.multiscatter[2] : m.alpha;
  const bool reflects = wi.z > 0;
  Vec h = reflects ? HalfOf(wo, wi) : Unit(-(near * wo + far * wi));
  if (h.z < 0) h = -h;
  FormulaValue out;
  const double oh = Dot(wo, h), ih = Dot(wi, h);
  if (oh <= 0 || ih * wi.z <= 0) return out;
  const double d = GgxDensity(h, x, y);
  const double lo = GgxLambda(wo, x, y), li = GgxLambda(wi, x, y);
  const GlassFacet facet = FacetOfGlass(material, oh, near, far);
  const double f = facet.largest;
  const double visible = d * oh / (wo.z * (1 + lo));  // density of h
  double value = 0;
  if (reflects) {
    out.pdf = f * visible / (4 * oh);
    value = f * d / (1 + lo + li) / (4 * wo.z);
  } else {
    const double jacobian = far * far * std::fabs(ih) / Square(near * oh + far * ih);
    out.pdf = (1 - f) * visible * jacobian;
    value = (1 - f) * d / (1 + lo + li) * oh / wo.z * jacobian * Square(near / far);
  }
  for (int c = 0; c < 3; ++c) {
    out.rgb[c] = GlassColor(m, reflects)[c] * value * (reflects ? facet.rgb[c] / f : 1);
  }
  return out;
}

// The transmittance of smooth glass for diffuse light from outside is integrated here.
double DiffuseTransmittanceOf(double ior) {
  static std::map<double, double> known;
  if (const auto found = known.find(ior); found != known.end()) return found->second;
  constexpr int kSteps = 20000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double sine = std::sin(kPi / 2 * (i + 0.5) / kSteps), cosine = std::sqrt(1 - sine * sine);
    sum += (1 - RealFresnel(cosine, 1 / ior)) * 2 * sine * cosine * kPi / 2 / kSteps;
  }
  return known[ior] = sum;
}

}  // namespace

GlassFacet FacetOfGlass(const MaterialCase& material, double cosine, double near, double far) {
  const MaterialRecord& m = material.record;
  const double fresnel = RealFresnel(cosine, near / far);
  const bool layered = m.specular_color[1] > 0 && fresnel < 1;  // PackMaterial gives it a colour
  if (!layered) return {glm::dvec3(fresnel), fresnel};
  const auto byte = [&](std::size_t column, int k) {
    return (material.layers[column] >> (8 * k) & 255) / 255.0;
  };
  const double f = Square((m.ior - 1.0) / (m.ior + 1.0)), specular = m.specular * byte(2, 3);
  glm::dvec3 f0;
  for (int c = 0; c < 3; ++c) {
    f0[c] = std::min(f * m.specular_color[c] * Square(byte(2, c)), 1.0) * specular;
  }
  GlassFacet facet;
  facet.rgb = glm::mix(f0, glm::dvec3(specular), std::max((fresnel - f) / (1 - f), 0.0));
  if (const double film = m.film * byte(3, 0); film > 0) {
    const double nm = std::lerp(double(m.grain[0]), double(m.grain[1]), byte(3, 1));
    const double outside =
        near == 1 ? cosine : std::sqrt(std::max(0.0, 1 - Square(near) * (1 - Square(cosine))));
    facet.rgb = glm::mix(facet.rgb, ThinFilmFormula(f0, m.film_ior, nm, outside), film);
  }
  facet.largest = std::max({facet.rgb.x, facet.rgb.y, facet.rgb.z});
  return facet;
}

GlassCoatWords CoatOfGlass(const MaterialRecord& record) {
  return {std::bit_cast<float>(record.sheen_texture),
          std::bit_cast<float>(record.sheen_alpha_texture)};
}

double FacetDensityOfGlass(const MaterialCase& material, Vec wo, Vec wi) {
  return GlassFacetsFormula(material, wo, wi).pdf;
}

// Adds the light that facets scatter more than once, by kernels/bsdf/dielectric_tables.h, in energy
// and not in radiance.
FormulaValue RoughDielectricFormula(const MaterialCase& material, Vec wo, Vec wi) {
  const MaterialRecord& m = material.record;
  FormulaValue out = GlassFacetsFormula(material, wo, wi);
  const auto table = std::bit_cast<std::uint32_t>(m.multiscatter[0]);
  if (table == 0) return out;
  const DielectricRow* const rows = DielectricsForTests()[table - 1].rows;
  // The rows are widths, or azimuths if there are two widths.
  const auto between = [&](Vec w, const auto& of_row) {
    const double place = m.multiscatter[2] > 0
                             ? std::fabs(w.y) / std::max(std::fabs(w.x) + std::fabs(w.y), 1e-30)
                             : std::sqrt(double(m.alpha));
    const double at = place * (kAlbedoRows - 1), low = std::floor(at);
    return std::lerp(of_row(rows[std::size_t(at)]), of_row(rows[std::size_t(at) + 1]), at - low);
  };
  const auto lost = [&](bool inside, Vec w) {
    const double place = std::sqrt(std::fabs(w.z)) * (kAlbedoColumns - 1);
    const auto column = std::min(std::size_t(place), std::size_t(kAlbedoColumns - 2));
    return between(w, [&](const DielectricRow& row) {
      return std::lerp(double(row.lost[inside][column]), double(row.lost[inside][column + 1]),
                       place - double(column));
    });
  };
  const auto mean = [&](bool inside) {
    return between(wo, [&](const DielectricRow& row) { return double(row.mean[inside]); });
  };
  const bool passes = wi.z < 0, wi_inside = material.back != passes;
  const double of_diffuse = DiffuseTransmittanceOf(m.ior) / (material.back ? Square(m.ior) : 1);
  const double own = mean(material.back), other = mean(!material.back);
  const double through = of_diffuse * other / std::max(own, other);
  const double lost_o = lost(material.back, wo), cosine = std::fabs(wi.z);
  const double share = passes ? through : 1 - through;
  double value = lost_o * share * lost(wi_inside, wi) / mean(wi_inside) * cosine / kPi;
  if (passes) value *= material.back ? Square(m.ior) : 1 / Square(m.ior);
  for (int c = 0; c < 3; ++c) out.rgb[c] += GlassColor(m, !passes)[c] * value;
  out.pdf = (1 - lost_o) * out.pdf + lost_o * share * cosine / kPi;
  return out;
}

// A conductor's lobe that reflects by glass's Fresnel, and one that is mirrored to the other side;
// and what both lose, of which diffuse light's share goes through (Kulla and Conty 2017).
FormulaValue RoughThinDielectricFormula(const MaterialCase& material, Vec wo, Vec wi) {
  const MaterialRecord& m = material.record;
  const bool reflects = wi.z > 0;
  const Vec up = {wi.x, wi.y, std::fabs(wi.z)}, h = HalfOf(wo, up);
  const GlassFacet facet = FacetOfGlass(material, std::min(Dot(wo, h), 1.0), 1, m.ior);
  const double f = facet.largest;
  const double lo = GgxLambda(wo, m.alpha, m.alpha), li = GgxLambda(up, m.alpha, m.alpha);
  const double lobe = (reflects ? f : 1 - f) * GgxDensity(h, m.alpha, m.alpha) / (4 * wo.z);
  FormulaValue out;
  out.pdf = lobe / (1 + lo);
  const double single = lobe / (1 + lo + li);
  double again = 0;
  if (m.multiscatter[1] > 0) {
    const auto lost = [&](Vec w) { return LostByGgx(m.alpha, w.z); };
    const double mean = MeanAt(GgxTables().padded_mean_albedo, m.alpha);
    const double through = DiffuseTransmittanceOf(m.ior);
    const double share = (reflects ? 1 - through : through) * up.z / kPi;
    again = share * lost(wo) * lost(up) / (1 - mean);
    out.pdf += lost(wo) * (share - out.pdf);
  }
  for (int c = 0; c < 3; ++c) {
    const double tint = reflects ? facet.rgb[c] / f : 1;
    out.rgb[c] = GlassColor(m, reflects)[c] * (tint * single + again);
  }
  return out;
}

}  // namespace skywave
