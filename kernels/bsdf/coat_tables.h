// What a dielectric coat lets through to a surface below it, and what light that is reflected to
// and fro between both adds.
//
// The coat is an interface of GGX facets as the rough dielectric has them (Walter et al. 2007, with
// single scattering), over a medium that may scatter and absorb. Light below it goes up and down
// until it leaves or is lost. Layers have no direction of their own, so albedos follow from the
// mean over all azimuths: tables of cosines suffice, and the reflections to and fro are a linear
// system (the method is that of adding and doubling, van de Hulst 1980).
//
// Over a diffuse body this is exact: the direction of light that has touched the body no longer
// depends on where it came from, so the BSDF is the coat's own lobe and a product of two functions,
// one for each direction. Over a metal the lobe is that of the metal as seen through a smooth coat,
// times such a product, which is chosen so that every directional albedo is exact.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/bsdf/conductor_tables.h"

namespace skywave {

struct Material;

// By column as in ConductorTables: the cosine is (column / (columns - 1))^2. The last value is
// repeated, so that interpolation needs no clamp.
using CoatColumn = float[kAlbedoColumns + 1];
struct CoatTable {
  CoatColumn own;         // directional albedo of the interface seen from outside
  CoatColumn through[3];  // factor for one direction of the lobe of what lies below
  CoatColumn medium[3];   // the same of the light that the medium returns, times wi.z [1/sqrt(sr)]
  float returned[3];      // over a diffuse body: share of its light that comes back to it
  float mean_through[3];  // mean of `through` over the cosine-weighted hemisphere
  float unused[3];
};
static_assert(sizeof(CoatTable) % sizeof(float) == 0);
inline constexpr std::uint32_t kCoatWords = sizeof(CoatTable) / sizeof(float);

// The parameters of a material on which its table depends.
using CoatKey = std::array<float, 16>;
CoatKey CoatKeyOf(const Material& material);

// Computes the table of a coated conductor or of a coated diffuse body in double; that takes about
// ten milliseconds, and a tenth of a second if the coat has a medium.
CoatTable MakeCoatTable(const Material& material);

// The widths of a material whose widths have an image (Material::roughness_texture) are those of
// rows: (row / (rows - 1))^2. Kernels interpolate between their tables, in the square root.
inline constexpr std::uint32_t kCoatRows = 12;
// Computes these tables: one for each width of the coat, and over a metal for each of those one for
// each width of the metal. That takes 0.1 s over a diffuse body and 1 s over a metal.
std::vector<CoatTable> MakeCoatTables(const Material& material);

// Returns the width of the lobe of a metal of width `alpha` under a coat: refraction at its facets,
// twice, widens the lobe.
float WidthUnderCoat(float alpha, float coat_alpha, float ior);

}  // namespace skywave
