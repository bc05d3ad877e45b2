#include "lights/maps/environment_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/error.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

Projection DetectProjection(const Image& image, const std::string& path) {
  const std::int64_t width = image.width, height = image.height;
  if (width == 2 * height) return Projection::kLatLong;
  if (width == 1 && height == 1) return Projection::kLatLong;
  if (width == height) return Projection::kAngular;
  if (3 * width == 4 * height) return Projection::kHorizontalCross;
  if (4 * width == 3 * height) return Projection::kVerticalCross;
  throw InputError(
      InputPosition::File(path),
      fmt::format("{} x {} pixels are neither a lat-long map (2:1) nor an angular map (square) nor "
                  "a cube cross (4:3, 3:4); say which with --env-projection {}",
                  width, height, Choices<Projection>()));
}

Image ToLatLong(Image image, Projection projection) {
  if (projection == Projection::kLatLong) return image;
  CheckProjectionSize(projection, image.width, image.height);
  const int height = LatLongHeight(projection, image.width, image.height);
  return Resample(image, projection, Projection::kLatLong, 2 * height, height);
}

void AngularPosition(const double direction[3], double& x, double& y) {
  const double sine = std::hypot(direction[0], direction[2]);
  if (sine == 0) {
    x = direction[1] >= 0 ? 0 : 1;
    y = 0;
    return;
  }
  const double radius = std::acos(std::clamp(direction[1], -1.0, 1.0)) / kPi;
  x = direction[0] / sine * radius;
  y = direction[2] / sine * radius;
}

double RowSolidAngle(int width, int height, int row) {
  const double top = kPi * row / height, bottom = kPi * (row + 1) / height;
  // The identity cos a - cos b = 2 sin((a + b) / 2) sin((b - a) / 2) does not cancel.
  return 2 * kPi / width * 2 * std::sin((top + bottom) / 2) * std::sin((bottom - top) / 2);
}

std::array<double, 3> SphereMean(const Image& latlong) {
  std::array<double, 3> mean = {};
  for (int row = 0; row < latlong.height; ++row) {
    const double weight = RowSolidAngle(latlong.width, latlong.height, row) / (4 * kPi);
    for (int column = 0; column < latlong.width; ++column) {
      for (int c = 0; c < 3; ++c) mean[c] += weight * latlong.Pixel(column, row)[c];
    }
  }
  return mean;
}

}  // namespace skywave
