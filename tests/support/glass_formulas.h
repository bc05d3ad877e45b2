// Rough glass, solid and thin, and layers over glass, by the papers (bsdf_formulas.h).
#pragma once

#include <glm/vec3.hpp>

#include "tests/support/bsdf_formulas.h"

namespace skywave {

// What a facet of glass reflects of light at a cosine, on the side of index `near`: Fresnel's
// reflectance, or what its layers make of it, whose brightest channel decides what goes through.
struct GlassFacet {
  glm::dvec3 rgb;
  double largest;
};
GlassFacet FacetOfGlass(const MaterialCase& material, double cosine, double near, double far);

// The coat of glass under one.
struct GlassCoatWords {
  float strength, alpha;
};
GlassCoatWords CoatOfGlass(const MaterialRecord& record);

FormulaValue RoughDielectricFormula(const MaterialCase& material, Vec wo, Vec wi);
FormulaValue RoughThinDielectricFormula(const MaterialCase& material, Vec wo, Vec wi);

// Returns the density of RoughDielectric without its lobes of scattering between facets.
double FacetDensityOfGlass(const MaterialCase& material, Vec wo, Vec wi);

}  // namespace skywave
