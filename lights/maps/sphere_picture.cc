#include "lights/maps/sphere_picture.h"

#include <algorithm>
#include <cmath>

namespace skywave {

SpherePicture::SpherePicture(const Image& image, Projection projection)
    : image_(image), projection_(projection) {
  if (projection == Projection::kHorizontalCross) face_ = image.width / 4;
  if (projection == Projection::kVerticalCross) face_ = image.width / 3;
  if (projection == Projection::kCubeStrip) face_ = image.width / 6;
  if (projection == Projection::kCubeColumn) face_ = image.width;
}

void SpherePicture::Add(ImagePoint point, double weight, std::array<double, 3>& sum) const {
  if (IsDisk(projection_)) {
    // The centres of the four pixels around a point are up to sqrt(2) pixels away: if it is kept
    // this far inside, the rim cuts none of them.
    const double x = 2 * point.u - 1, y = 2 * point.v - 1, r = std::sqrt(x * x + y * y);
    const double limit = std::max(0.0, 1 - 3.0 / std::min(image_.width, image_.height));
    if (r > limit) {
      point = {(1 + x * limit / r) / 2, (1 + y * limit / r) / 2};
    }
  }
  const double px = point.u * image_.width - 0.5, py = point.v * image_.height - 0.5;
  const int x0 = int(std::floor(px)), y0 = int(std::floor(py));
  const double fx = px - x0, fy = py - y0;
  const Range columns = Bounds(point.u, image_.width), rows = Bounds(point.v, image_.height);
  if (x0 >= columns.begin && x0 + 1 < columns.end && y0 >= rows.begin && y0 + 1 < rows.end) {
    // Nothing wraps around.
    const float *const above = image_.Pixel(x0, y0), *const below = image_.Pixel(x0, y0 + 1);
    for (int c = 0; c < 3; ++c) {
      const double upper = (1 - fx) * above[c] + fx * above[c + 3];
      const double lower = (1 - fx) * below[c] + fx * below[c + 3];
      sum[c] += weight * ((1 - fy) * upper + fy * lower);
    }
    return;
  }
  AddTexel(x0, y0, columns, rows, weight * (1 - fx) * (1 - fy), sum);
  AddTexel(x0 + 1, y0, columns, rows, weight * fx * (1 - fy), sum);
  AddTexel(x0, y0 + 1, columns, rows, weight * (1 - fx) * fy, sum);
  AddTexel(x0 + 1, y0 + 1, columns, rows, weight * fx * fy, sum);
}

SpherePicture::Range SpherePicture::Bounds(double position, int size) const {
  if (face_ == 0) return {0, size};
  const int face = std::clamp(int(position * size) / face_, 0, size / face_ - 1);
  return {face * face_, (face + 1) * face_};
}

void SpherePicture::AddTexel(int x, int y, Range columns, Range rows, double weight,
                             std::array<double, 3>& sum) const {
  if (weight == 0) return;
  if (projection_ == Projection::kLatLong) {
    // Beyond a pole the sphere continues half a turn away.
    if (y < 0 || y >= image_.height) {
      y = y < 0 ? -1 - y : 2 * image_.height - 1 - y;
      x += image_.width / 2;
    }
    x = (x % image_.width + image_.width) % image_.width;
  } else if (projection_ == Projection::kOctahedral) {
    // Every edge of the square is folded at its middle.
    const int width = image_.width, height = image_.height;
    if (x < 0 || x >= width) {
      x = x < 0 ? -1 - x : 2 * width - 1 - x;
      y = height - 1 - y;
    }
    if (y < 0 || y >= height) {
      y = y < 0 ? -1 - y : 2 * height - 1 - y;
      x = width - 1 - x;
    }
  }
  x = std::clamp(x, columns.begin, columns.end - 1);
  y = std::clamp(y, rows.begin, rows.end - 1);
  const float* rgb = image_.Pixel(x, y);
  for (int c = 0; c < 3; ++c) sum[c] += weight * rgb[c];
}

}  // namespace skywave
