// An inversion table holds the trees of a two-dimensional inversion (kernels/lights/environment.h)
// with their densities.
#pragma once

#include <vector>

#include "lights/tables/search_tree.h"
#include "lights/tables/texels.h"

namespace skywave {

// Returns the luminance that importance sampling subtracts from all texels: `compensate` (0 to 1)
// times the mean over the sphere. A map that rises above it by no more than the rounding of its
// texels has nothing to compensate: then `compensate` becomes 0. A black map gets -1, so all its
// texels weigh the same.
float BaseLuminance(const Texels& texels, double& compensate);

class InversionTable {
 public:
  // Directions are drawn with a probability proportional to max(0, luminance - base) times solid
  // angle, except for a rounding that the density includes. Some texel must rise above the base.
  // `texels` must outlive the table and serve no other one, because their lines get the densities.
  InversionTable(Texels& texels, float base);

  InversionView view() const;
  std::size_t bytes() const { return rows_.bytes() + lines_.bytes(); }

 private:
  const Texels* texels_;
  float base_;  // in units of the texels
  SearchTrees rows_, lines_;
};

}  // namespace skywave
