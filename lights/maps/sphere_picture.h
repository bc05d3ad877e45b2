// A picture of the sphere is read between its pixel centres, in any projection.
#pragma once

#include <array>

#include "image/image.h"
#include "lights/maps/projections.h"

namespace skywave {

// True for projections whose picture is a disk, so that its rim cuts pixels.
inline bool IsDisk(Projection projection) {
  return projection == Projection::kAngular || projection == Projection::kMirrorBall;
}

class SpherePicture {
 public:
  // `image` is borrowed and must outlive the object.
  SpherePicture(const Image& image, Projection projection);

  // Adds weight * radiance at a point that has light, bilinear between the centres of pixels.
  // Interpolation goes across the seam and the poles of a lat-long map and over the folds of an
  // octahedral square, never across the rim of a disk or the edges of faces.
  void Add(ImagePoint point, double weight, std::array<double, 3>& sum) const;

 private:
  // Interpolation may read this half-open range of columns or rows around a coordinate.
  struct Range {
    int begin, end;
  };
  Range Bounds(double position, int size) const;
  void AddTexel(int x, int y, Range columns, Range rows, double weight,
                std::array<double, 3>& sum) const;

  const Image& image_;
  Projection projection_;
  int face_ = 0;  // side of a cube's face [pixels]; 0: no cube
};

}  // namespace skywave
