// Light in the layers of a coated surface, followed one path at a time: a dielectric interface of
// GGX facets, a medium, and a diffuse body or a metal. It is slow, in double, and shares no code
// with the engine, so that it can judge coats (kernels/bsdf/coat_tables.h).
#pragma once

#include <array>

#include "kernels/bsdf/material.h"
#include "tests/support/random_rows.h"

namespace skywave {

// Where light leaves the layers, and what is left of it; nothing is left of light that is lost.
struct LayeredPath {
  Vec direction = {};
  double weight = 0;
};

// Follows light that comes from `wo`, whose z is its cosine, through a coated conductor or a coated
// diffuse body. Of the three channels `channel` counts.
LayeredPath WalkLayers(const Material& material, int channel, Vec wo, Random& random);

}  // namespace skywave
