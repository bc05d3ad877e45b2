// The light that the facets of a rough dielectric scatter more than once.
//
// Single scattering (Walter et al. 2007) loses it: a share lost(w) of the light that comes from w.
// As Kulla and Conty 2017 ("Revisiting Physically Based Shading at Imageworks") do for dielectrics,
// lobes that are products of lost(wo) and lost(wi) return it, on the side where it came from and on
// the other one. Their split follows from two conditions: the light that crosses the interface is
// the same in both directions, which makes the BSDF reciprocal up to the squared index, and no
// side gets back more than it loses. Let L be the mean of `lost` over the cosine-weighted
// hemisphere of a side, t the transmittance of the smooth interface for diffuse light from outside,
// and n the index inside over that outside. The light lost outside is split by
//   through = t L_in / max(L_out, L_in),        the rest is reflected,
// that lost inside by
//   through = t / n^2 L_out / max(L_out, L_in), the rest is reflected,
// which is the split of diffuse light by Fresnel's formulae wherever both sides lose alike.
#pragma once

#include <cstdint>

#include "kernels/bsdf/conductor_tables.h"

namespace skywave {

// What is lost by row and column as in ConductorTables. A row has the columns of the side outside
// (where normals point to), those of the side inside, and the means of both.
inline constexpr std::uint32_t kSideColumns = kAlbedoColumns + 1;
struct DielectricRow {
  float lost[2][kSideColumns];
  float mean[2];
};
struct DielectricTable {
  DielectricRow rows[kAlbedoRows + 1];
};
inline constexpr std::uint32_t kDielectricRowWords = sizeof(DielectricRow) / sizeof(float);
inline constexpr std::uint32_t kDielectricWords = sizeof(DielectricTable) / sizeof(float);

// Computes the table of facets of width `alpha`, whose rows are all alike; that takes 5 ms.
DielectricTable MakeDielectricTable(float alpha, float ior);
// Computes the table of facets of two widths, whose rows are not widths but azimuths: row r is for
// |y| / (|x| + |y|) = r / (rows - 1), where x is along the first width. That takes 0.2 s.
DielectricTable MakeDielectricTable(float along, float across, float ior);
// Computes the table for the widths of the rows; that takes 0.2 s.
DielectricTable MakeDielectricTable(float ior);

// Returns the transmittance of a smooth interface for diffuse light from outside.
float DiffuseTransmittance(float ior);

}  // namespace skywave
