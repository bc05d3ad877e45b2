// What rounding to floats does to the value and density of a BSDF, from its formula in double: how
// far a kernel may be off it.
#pragma once

#include "tests/support/bsdf_cases.h"

namespace skywave {

// By how much value and density of BsdfFormula change if both directions move by so many roundings
// of 2^-24, each way along each axis, summed over the axes: kernels round directions when they turn
// them into their frame, and half vectors, which depend on both. Beside that, where light is
// refracted, if the index moves by two roundings and the cosine from which the kernel has Fresnel's
// reflectance by four (next to total reflection 1 - F goes with the root of a difference of numbers
// near 1); and where a cosine is raised to a power, if that moves by six, the sum of three products
// of either evaluation.
FormulaValue ChangeByRounding(const MaterialCase& material, Vec wo, Vec wi, int roundings);

}  // namespace skywave
