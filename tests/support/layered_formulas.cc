#include "tests/support/layered_formulas.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "kernels/bsdf/conductor_tables.h"
#include "tests/support/facet_formulas.h"

namespace skywave {
namespace {

using glm::dvec3;

// Returns byte `byte` of column `column` in [0, 1].
double ShareOf(const MaterialCase& material, std::size_t column, int byte) {
  return (material.layers[column] >> (8 * byte) & 255) / 255.0;
}
dvec3 ColorOf(const MaterialCase& material, std::size_t column) {
  dvec3 color;
  for (int c = 0; c < 3; ++c) color[c] = Square(ShareOf(material, column, c));
  return color;
}
double Width(double factor, double roughness) {
  return std::clamp(factor * Square(roughness), 1e-3, 1.0);
}
double LargestOf(const dvec3& rgb) { return std::max({rgb.x, rgb.y, rgb.z}); }

// The mean of AnisotropicAlbedoAt over diffuse light.
double AnisotropicMeanAt(double along, double across) {
  const AnisotropicTables& tables = GetAnisotropicTables();
  const double x = std::sqrt(along) * (kTabledWidths - 1),
               y = std::sqrt(across) * (kTabledWidths - 1);
  const auto i = std::min(std::size_t(x), std::size_t(kTabledWidths - 2)),
             j = std::min(std::size_t(y), std::size_t(kTabledWidths - 2));
  const auto row = [&](std::size_t at) {
    return std::lerp(double(tables.mean_albedo[at][j]), double(tables.mean_albedo[at][j + 1]),
                     y - double(j));
  };
  return std::lerp(row(i), row(i + 1), x - double(i));
}

// The parameters of a case, and what its formulae make of them.
struct Layers {
  dvec3 color, coat, f0;
  double metallic, x, y, alpha, f90, coat_f0, coat_f90, film, film_ior, film_nm;
  bool grained;

  explicit Layers(const MaterialCase& material) {
    const MaterialRecord& m = material.record;
    color = {m.color[0], m.color[1], m.color[2]};
    metallic = m.eta[0] * ShareOf(material, 0, 1);
    const double width = Width(m.alpha, ShareOf(material, 0, 0));
    const double strength = std::hypot(m.grain[0], m.grain[1]) * ShareOf(material, 3, 2);
    grained = strength > 0;
    x = std::lerp(width, 1.0, Square(strength)), y = width;
    alpha = std::sqrt(x * y);
    const double specular = m.specular * ShareOf(material, 2, 3);
    for (int c = 0; c < 3; ++c) {
      const double f = Square((m.ior - 1.0) / (m.ior + 1.0)) * double(m.specular_color[c]);
      coat[c] = std::min(f * ColorOf(material, 2)[c], 1.0) * specular;
    }
    coat_f0 = LargestOf(coat), coat_f90 = specular;
    f0 = glm::mix(coat, color, metallic);
    f90 = std::lerp(specular, 1.0, metallic);
    film = m.film * ShareOf(material, 3, 0), film_ior = m.film_ior;
    film_nm = std::lerp(double(m.eta[1]), double(m.eta[2]), ShareOf(material, 3, 1));
  }
  dvec3 OfFilm(const dvec3& below, double cosine) const {
    return ThinFilmFormula(below, film_ior, film_nm, cosine);
  }
  dvec3 OfFilm(double cosine) const {
    return glm::mix(OfFilm(coat, cosine), OfFilm(color, cosine), metallic);
  }
  dvec3 Fresnel(double cosine) const {
    const double away = Power5(1 - cosine);
    return glm::mix(f0 * (1 - away) + f90 * away, OfFilm(cosine), film);
  }
  double Albedo(Vec w) const {
    return grained ? AnisotropicAlbedoAt(x, y, w) : TableAt(GgxTables().albedo, alpha, w.z);
  }
  double Grazing(Vec w) const {
    return std::min(TableAt(GgxTables().grazing, alpha, w.z), Albedo(w));
  }
  double Through(Vec w) const {
    const double plain = coat_f0 * (Albedo(w) - Grazing(w)) + coat_f90 * Grazing(w);
    return 1 - std::lerp(plain, LargestOf(OfFilm(coat, w.z)) * Albedo(w), film);
  }
  double Specular(Vec w) const {
    const double plain = LuminanceOf(f0) * (Albedo(w) - Grazing(w)) + f90 * Grazing(w);
    return std::lerp(plain, LuminanceOf(OfFilm(w.z)) * Albedo(w), film);
  }
};

// The height, the middle [1/m] and the variance of Belcour and Barla's Gaussians of x, x, y and z.
constexpr double kGaussians[4][3] = {{5.4856e-13, 1.6810e6, 4.3278e9},
                                     {9.7470e-14, 2.2399e6, 4.5282e9},
                                     {4.4201e-13, 1.7953e6, 9.3046e9},
                                     {5.2481e-13, 2.2084e6, 6.6121e9}};

dvec3 Rec709FromGaussians(const double (&g)[4]) {
  const double x = (g[0] + g[1]) / 1.0685e-7, y = g[2] / 1.0685e-7, z = g[3] / 1.0685e-7;
  return {3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
          -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
          0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
}

}  // namespace

MaterialRecord LayersAtHit(const MaterialCase& material) {
  MaterialRecord record = material.record;
  record.k[1] = float(Width(record.k[1], ShareOf(material, 0, 2)));
  record.k[2] = std::max(float(Width(record.k[2], ShareOf(material, 0, 3))), kMinSheenAlpha);
  for (int c = 0; c < 3; ++c) record.multiscatter[c] *= float(ColorOf(material, 1)[c]);
  return record;
}

double LobeWidthOfLayers(const MaterialCase& material) {
  const MaterialRecord here = LayersAtHit(material);
  const double facets = Layers(material).y;
  return here.k[0] > 0 ? std::min(facets, double(here.k[1])) : facets;
}

// Each term is |r12|, the light that the top reflects, and that which has crossed the film once and
// more: amplitudes are the roots of Schlick's reflectances.
dvec3 ThinFilmFormula(const dvec3& f0, double ior, double nm, double cosine) {
  const double there = std::clamp(nm / 0.03, 0.0, 1.0);
  const double film = 1 + (ior - 1) * there * there * (3 - 2 * there);
  const double inner = std::sqrt(1 - (1 - cosine * cosine) / Square(film));
  const double path = 2e-9 * film * nm * inner;
  const auto schlick = [](double at_normal, double c) {
    return at_normal + (1 - at_normal) * Power5(1 - c);
  };
  const double r12 = schlick(Square((film - 1) / (film + 1)), cosine);
  const auto waves = [&](double order) {
    double g[4];
    for (int i = 0; i < 4; ++i) {
      const double phase = 2 * kPi * order * path;
      g[i] = kGaussians[i][0] * std::sqrt(2 * kPi * kGaussians[i][2]) *
             std::cos(phase * kGaussians[i][1]) * std::exp(-phase * phase * kGaussians[i][2]);
    }
    return Rec709FromGaussians(g);
  };
  const dvec3 wave1 = waves(1), wave2 = waves(2);
  dvec3 rgb;
  for (int c = 0; c < 3; ++c) {
    const double root = std::sqrt(std::clamp(f0[c], 0.0, 0.9999));
    const double below = (1 + root) / (1 - root);
    const double r23 = schlick(Square((below - film) / (below + film)), inner);
    const double both = std::clamp(r12 * r23, 1e-5, 0.9999);
    const double steady = Square(1 - r12) * r23 / (1 - both), wave = steady - (1 - r12);
    const double turned = below < film ? 1 : -1;
    rgb[c] = std::clamp(
        r12 + steady + 2 * wave * turned * std::sqrt(both) * wave1[c] + 2 * wave * both * wave2[c],
        0.0, 1.0);
  }
  return rgb;
}

FormulaValue LayeredBaseFormula(const MaterialCase& material, Vec wo, Vec wi) {
  const Layers l(material);
  const double single_mean =
      l.grained ? AnisotropicMeanAt(l.x, l.y) : MeanAt(GgxTables().padded_mean_albedo, l.alpha);
  const double grazing_mean = MeanAt(GgxTables().mean_grazing, l.alpha);
  double coat_mean = 0;
  dvec3 metal_mean(0);
  for (const auto& [at, weight] :
       {std::pair(0.21234054, 0.13965396), {0.59053314, 0.45848221}, {0.91141204, 0.40186383}}) {
    coat_mean +=
        weight * LargestOf(l.OfFilm(l.coat, at)) * TableAt(GgxTables().albedo, l.alpha, at);
    metal_mean += weight * l.OfFilm(l.color, at);
  }
  const double mirrored = std::lerp(
      l.coat_f0 * (single_mean - grazing_mean) + l.coat_f90 * grazing_mean, coat_mean, l.film);
  const dvec3 f = glm::mix((20.0 * l.color + 1.0) / 21.0, metal_mean, l.film);
  const double lost = 1 - single_mean, lost_o = 1 - l.Albedo(wo), lost_i = 1 - l.Albedo(wi);

  const Vec h = HalfOf(wo, wi);
  const double lobe = GgxDensity(h, l.x, l.y) / (4 * wo.z);
  const double lo = GgxLambda(wo, l.x, l.y), li = GgxLambda(wi, l.x, l.y);
  const dvec3 single = l.Fresnel(std::min(Dot(wo, h), 1.0)) * (lobe / (1 + lo + li));
  const double body = (1 - l.metallic) * l.Through(wo) * l.Through(wi) / (kPi * (1 - mirrored));
  const double again = l.metallic * single_mean / (kPi * lost) * lost_o * lost_i;
  FormulaValue out;
  for (int c = 0; c < 3; ++c) {
    const double multiple = again * f[c] * f[c] / (1 - f[c] * lost);
    out.rgb[c] = single[c] + wi.z * (body * l.color[c] + multiple);
  }
  const double rest = l.Through(wo) * (1 - l.metallic) * LuminanceOf(l.color) +
                      lost_o * l.metallic * LuminanceOf(l.color);
  const double share = std::clamp(l.Specular(wo) / (l.Specular(wo) + rest), 0.1, 0.9);
  out.pdf = share * lobe / (1 + lo) + (1 - share) * wi.z / kPi;
  return out;
}

}  // namespace skywave
