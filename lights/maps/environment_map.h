// An illumination map before any strategy looks at it: a lat-long picture of finite, non-negative
// radiance and the way it lies in the world.
#pragma once

#include <array>
#include <string>

#include "image/image.h"

namespace skywave {

// How the pixels of a map file lie on the sphere: lights/maps/projections.h has the conventions.
enum class Projection {
  kLatLong,
  kAngular,
  kMirrorBall,
  kHorizontalCross,
  kVerticalCross,
  kCubeStrip,
  kOctahedral,
};

struct EnvironmentMap {
  Image latlong;                        // conventions: kernels/lights/environment.h
  std::array<float, 9> map_from_world;  // rows: right, forward, up; orthonormal, may mirror
};

// 2:1 is lat-long, square Debevec's angular map, 4:3 a horizontal and 3:4 a vertical cube cross.
// Throws InputError for any other shape, naming `path` and the flag that decides.
Projection DetectProjection(const Image& image, const std::string& path);

// Lat-long version of a map: itself, or any other projection resampled (lights/maps/resample.h) to
// a size that keeps its angular resolution: as many columns as an angular map has, 4 columns for 3
// of a ball or an octahedral square, 4 for each pixel of a cube's edge. Throws InputError for a
// cube whose faces are not square.
Image ToLatLong(Image image, Projection projection);

// Direction in map space (right, forward, up) to a point of the angular map in [-1, 1]^2, x to the
// right, y up: r = acos(forward) / pi away from the centre (Debevec 1998).
void AngularPosition(const double direction[3], double& x, double& y);

// Mean radiance over the sphere, per channel, each row weighted by its exact solid angle.
std::array<double, 3> SphereMean(const Image& latlong);

// Solid angle of one pixel of row `row` [sr]: 2 pi / width * (cos(theta_0) - cos(theta_1)).
double RowSolidAngle(int width, int height, int row);

}  // namespace skywave
