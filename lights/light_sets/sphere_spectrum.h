// The power spectrum of a set of directions says how evenly they lie on the sphere.
#pragma once

#include <span>
#include <vector>

#include "lights/vector3.h"

namespace skywave {

// Returns the mean power of the spherical harmonics of degrees 0 to `degrees`, relative to that of
// as many independent uniform directions, which have 1 at every degree but 0. By the addition
// theorem that of degree l is the mean over i of the sum over j of the Legendre polynomial P_l of
// the cosine between directions i and j. Directions as far apart as N can be have a peak near l =
// 1.07 sqrt(pi N), and those of blue noise almost no power at half of that. Takes N^2 * degrees
// steps.
std::vector<double> SpherePower(std::span<const Vector3> directions, int degrees);

}  // namespace skywave
