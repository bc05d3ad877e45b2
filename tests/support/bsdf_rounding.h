// Estimates the effect of float rounding on the value and density of a BSDF, from its formula in
// double: the deviation that a kernel may have.
#pragma once

#include "tests/support/bsdf_cases.h"
#include "tests/support/bsdf_formulas.h"

namespace skywave {

// Returns the change of value and density of BsdfFormula if either direction moves by `roundings`
// roundings of 2^-24, in both senses along each axis, summed over the axes: kernels round
// directions when they transform them into their frame, and half vectors, which depend on both. For
// refraction, it adds the change if the index moves by two roundings and the cosine for the
// kernel's Fresnel reflectance by four (near total internal reflection, 1 - F behaves like the root
// of a difference of numbers near 1). For a power of a cosine, it adds the change if the cosine
// moves by six, the sum of three products in both evaluations.
FormulaValue ChangeByRounding(const MaterialCase& material, Vec wo, Vec wi, int roundings);

}  // namespace skywave
