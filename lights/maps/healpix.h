// HEALPix (Gorski et al. 2005) divides the sphere into twelve squares of equal areas, four about
// each pole and four along the equator. Areas inside a square are those on the sphere times 3 / pi,
// so a pattern of the plane that is laid into the squares is as dense everywhere.
#pragma once

#include "lights/vector3.h"

namespace skywave {

inline constexpr int kHealpixSquares = 12;
// A step of length s inside a square is at most kHealpixStretch * s long on the sphere [rad]: this
// is the largest singular value of the map's derivative. It is reached at the poles, where its
// square is (t + sqrt(t^2 - 4 (pi / 3)^2)) / 2 with t = 4 / 3 + pi^2 / 6.
inline constexpr double kHealpixStretch = 1.6;

// Returns the direction of the point (x, y) in [0, 1]^2 of a square: a unit vector in map space.
// Squares 0 to 3 are those about up, 4 to 7 those along the equator.
Vector3 DirectionOfHealpix(int square, double x, double y);

}  // namespace skywave
