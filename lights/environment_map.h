// An illumination map before any strategy looks at it: a lat-long picture of finite, non-negative
// radiance and the way it lies in the world.
#pragma once

#include <array>
#include <string>

#include "image/image.h"

namespace skywave {

// How the pixels of a map file lie on the sphere.
enum class Projection { kLatLong, kAngular };

struct EnvironmentMap {
  Image latlong;                        // conventions: kernels/environment.h
  std::array<float, 9> map_from_world;  // rows: right, forward, up; orthonormal, may mirror
};

// Twice as wide as high: lat-long; square: Debevec's angular map. Throws InputError for any other
// shape, naming `path` and the flag that decides.
Projection DetectProjection(const Image& image, const std::string& path);

// Lat-long version of a map: itself, or an angular map resampled to width x width / 2, which keeps
// the angular resolution of the original. Every lat-long pixel is the mean of 4 x 4 interpolated
// samples; pixels outside the disk are never read.
Image ToLatLong(Image image, Projection projection);

// Direction in map space (right, forward, up) to a point of the angular map in [-1, 1]^2, x to the
// right, y up: r = acos(forward) / pi away from the centre (Debevec 1998).
void AngularPosition(const double direction[3], double& x, double& y);

// Mean radiance over the sphere, per channel, each row weighted by its exact solid angle.
std::array<double, 3> SphereMean(const Image& latlong);

// Solid angle of one pixel of row `row` [sr]: 2 pi / width * (cos(theta_0) - cos(theta_1)).
double RowSolidAngle(int width, int height, int row);

}  // namespace skywave
