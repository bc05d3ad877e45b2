// Layered metallic-roughness by its formulae, in double (kernels/bsdf/layered_metallic_roughness.cc
// and thin_film-inl.h).
#pragma once

#include <glm/vec3.hpp>

#include "tests/support/bsdf_formulas.h"

namespace skywave {

// Returns the value under sheen and coat. Directions are in the frame of the tangent.
FormulaValue LayeredBaseFormula(const MaterialCase& material, Vec wo, Vec wi);
// Returns the record with the factors that the textures of the case give to sheen and coat.
MaterialRecord LayersAtHit(const MaterialCase& material);
double LobeWidthOfLayers(const MaterialCase& material);

// Returns what a film of index `ior` and thickness `nm` over a surface of `f0` reflects.
glm::dvec3 ThinFilmFormula(const glm::dvec3& f0, double ior, double nm, double cosine);

}  // namespace skywave
