// What each BSDF is by the papers, apart from the kernels.
#pragma once

#include "tests/support/shading_rows.h"

namespace skywave {

// Value and density in double, from the formulae of the papers, in a local frame with z the normal
// and x the tangent. Unknown where a table has a step.
struct FormulaValue {
  double rgb[3] = {};
  double pdf = 0;
  bool known = true;
};
FormulaValue BsdfFormula(const MaterialCase& material, Vec wo, Vec wi);

// Returns what a padded table of means has for a width.
double MeanAt(const float* table, double alpha);

// These interpolate the tables of kernels/bsdf/conductor_tables.h: for one width, bilinearly in the
// square roots, and for two.
double TableAt(const float* table, double alpha, double cosine);
double AnisotropicAlbedoAt(double along, double across, Vec w);

// Returns the share of light that white GGX facets scatter more than once, by the tables of the
// kernels.
double LostByGgx(double alpha, double cosine);

}  // namespace skywave
