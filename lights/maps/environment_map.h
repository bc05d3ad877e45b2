// An illumination map is a lat-long picture of finite, non-negative radiance, with its orientation
// in the world.
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "image/image.h"
#include "kernels/lights/portals.h"

namespace skywave {

// A projection lays the pixels of a map file on the sphere: lights/maps/projections.h has the
// conventions.
enum class Projection {
  kLatLong,
  kAngular,
  kMirrorBall,
  kHorizontalCross,
  kVerticalCross,
  kCubeStrip,
  kCubeColumn,
  kOctahedral,
};

// An image that nobody changes any more, which all orientations of a map have together.
class SharedImage {
 public:
  SharedImage() : SharedImage(Image()) {}
  SharedImage(Image image) : image_(std::make_shared<const Image>(std::move(image))) {}
  explicit SharedImage(std::shared_ptr<const Image> image) : image_(std::move(image)) {}
  operator const Image&() const { return *image_; }
  const Image* operator->() const { return image_.get(); }

 private:
  std::shared_ptr<const Image> image_;  // not null
};

struct EnvironmentMap {
  SharedImage latlong;                  // conventions: kernels/lights/environment.h
  std::array<float, 9> map_from_world;  // rows: right, forward, up; orthonormal, may mirror
  std::vector<Portal> portals = {};     // openings through which its light comes in
};

// Maps a direction in map space (right, forward, up) to a point of the angular map in [-1, 1]^2, x
// to the right, y up: r = acos(forward) / pi away from the centre (Debevec 1998).
void AngularPosition(const double direction[3], double& x, double& y);

// Returns the mean radiance over the sphere per channel, each row weighted by its exact solid
// angle.
std::array<double, 3> SphereMean(const Image& latlong);

// Returns the solid angle of one pixel of row `row` [sr]: 2 pi / width * (cos(theta_0) -
// cos(theta_1)).
double RowSolidAngle(int width, int height, int row);

}  // namespace skywave
