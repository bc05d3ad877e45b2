// The directional albedo of the GGX reflection lobe with Fresnel reflectance 1 is the energy that
// single scattering between microfacets keeps. The multiple-scattering lobe of Kulla and Conty 2017
// ("Revisiting Physically Based Shading at Imageworks") returns the rest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace skywave {

// Row r of the grid is for alpha = (r / (rows - 1))^2, column c for the cosine (c / (columns -
// 1))^2; both squares put nodes where the albedo bends.
inline constexpr std::uint32_t kAlbedoRows = 32, kAlbedoColumns = 32;

struct ConductorTables {
  // The grid is padded by a column and a row that repeat the last, so that interpolation needs no
  // clamp.
  float albedo[(kAlbedoRows + 1) * (kAlbedoColumns + 1)];
  // This is the mean of the albedo over the cosine-weighted hemisphere, one value per row.
  float mean_albedo[kAlbedoRows];
  // These are the same for a lobe with Fresnel reflectance (1 - cos)^5: by Schlick's formula the
  // lobe of F0 has the albedo F0 * albedo + (1 - F0) * grazing. Means are padded by a row like the
  // grids.
  float grazing[(kAlbedoRows + 1) * (kAlbedoColumns + 1)];
  float padded_mean_albedo[kAlbedoRows + 1];
  float mean_grazing[kAlbedoRows + 1];
};

// Returns the mean over the cosine-weighted hemisphere of a column of such a table, as kernels
// interpolate it.
template <std::size_t kColumns>
double MeanOverCosine(const std::array<double, kColumns>& column) {
  constexpr int kSteps = 1024;
  double mean = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) / kSteps, at = s * (kColumns - 1);
    const auto low = std::uint32_t(at);
    const double high_share = at - low;
    const double e = column[low] * (1 - high_share) +
                     column[std::min<std::size_t>(low + 1, kColumns - 1)] * high_share;
    mean += e * 4 * s * s * s / kSteps;
  }
  return mean;
}

// Returns that of a table of cosines and azimuths, at(azimuth, column), whose azimuths are equally
// spaced in |y| / (|x| + |y|).
template <std::size_t kColumns, class At>
double MeanOverHemisphere(std::size_t azimuths, const At& at) {
  constexpr int kTurns = 128;
  std::array<double, kColumns> column = {};
  for (int turn = 0; turn < kTurns; ++turn) {
    const double phi = std::numbers::pi / 2 * (turn + 0.5) / kTurns;
    const double place = std::sin(phi) / (std::sin(phi) + std::cos(phi)) * double(azimuths - 1);
    const auto low = std::min(std::size_t(place), azimuths - 2);
    for (std::size_t c = 0; c < kColumns; ++c) {
      column[c] +=
          std::lerp(double(at(low, c)), double(at(low + 1, c)), place - double(low)) / kTurns;
    }
  }
  return MeanOverCosine(column);
}

// Returns the tables, which the first call computes in double, by quadrature over the visible
// normals; that takes tens of milliseconds.
const ConductorTables& GgxTables();

// Returns the factor of (1 - E(wo)) (1 - E(wi)) cos(wi) in the multiple-scattering lobe, for one
// channel of a conductor with index eta + i k and GGX width alpha [1/sr].
float ConductorMultiscatter(const ConductorTables& tables, float alpha, float eta, float k);

// The same albedo for facets of two widths. Places are equally spaced in the square roots of the
// widths and of the cosine, from 0 to 1, and in |y| / (|x| + |y|) of the direction, whose x is
// along the first width. Interpolation in all four makes errors of 0.2 % on average, and of 1 % at
// most at cosines above 0.1, or 1.5 % where one width is six times the other or more.
inline constexpr std::uint32_t kTabledWidths = 12, kTabledCosines = 16, kTabledAzimuths = 13;
struct AnisotropicTables {
  float albedo[kTabledWidths][kTabledWidths][kTabledCosines][kTabledAzimuths];
  // This is the mean over the cosine-weighted hemisphere.
  float mean_albedo[kTabledWidths][kTabledWidths];
};

// Returns the tables, which the first call computes in double; that takes 0.3 s.
const AnisotropicTables& GetAnisotropicTables();

// Returns ConductorMultiscatter for facets of two widths.
float ConductorMultiscatter(const AnisotropicTables& tables, float along, float across, float eta,
                            float k);

// The albedo of the sheen lobe (Estevez and Kulla 2017, "Production Friendly Microfacet Sheen
// BRDF": D = (2 + 1 / alpha) sin^(1 / alpha) / (2 pi), with Neubelt's visibility 1 / (4 (cos_o +
// cos_i - cos_o cos_i))), on the grid of ConductorTables. Narrow lobes would reflect more light
// than they get at grazing angles: the lobe and its albedo are multiplied by `scale`, so that none
// exceeds 1.
struct SheenTables {
  float albedo[(kAlbedoRows + 1) * (kAlbedoColumns + 1)];
  float scale[kAlbedoRows + 1];  // by row
};
inline constexpr float kMinSheenAlpha = 0.04f;  // narrower ones are taken for this wide

// Returns the tables, which the first call computes in double in about a tenth of a second.
const SheenTables& GetSheenTables();

}  // namespace skywave
