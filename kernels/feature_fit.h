// This kernel repairs pixels that hardly equal any other one, such as those that an edge divides:
// by first-order regression on features.
//
// Around such a pixel i the radiance y is taken for a linear function of the features f, which its
// neighbours' averages y_j, with noise v_j, tell (Moon et al. 2014; NFOR, Bitterli et al. 2016):
//
//   minimise over a and b:  sum of w_j |y_j - a - b (f_j - f_i)|^2 + ridge,  w_j ~ 1 / (v_j + v_0).
//
// That is true of a pixel that shows a share of each of two surfaces: its features are mixed from
// those of both by the same share, and from the same samples. The intercept a is what they say of
// pixel i, whose own value is not among the y_j. It is a sum of h_j y_j, so its variance is that of
// h_j^2 v_j, and what the fit leaves of the y_j says how wrong a linear function is here.
#pragma once

#include "kernels/cross_filter.h"

namespace skywave {

// Writes row `y` of both halves: the values of `in` (CrossFilter) where these have lost most of the
// noise of the `noisy` ones; elsewhere their mean with what a fit to the neighbours says, weighted
// by the inverses of their variances, to which the fit's own error is added. The weights of one
// half come from the other one. `brightness` is a unit of radiance. The rim of `out` is not
// written.
void FitToFeatures(const PlaneShape& shape, const FeaturePlanes& features,
                   const TexturePlanes& texture, float brightness, const HalfPlanes (&noisy)[2],
                   const HalfPlanes (&in)[2], int y, const HalfPlanes (&out)[2]);

}  // namespace skywave
