#include "lights/environment_map.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

// Bilinear sample of the angular map at (x, y) in the unit disk, kept a pixel and a half inside the
// rim: the centres of the four pixels around a point are up to sqrt(2) pixels away.
void AddAngularSample(const Image& image, double x, double y, double sum[3]) {
  const double limit = std::max(0.0, 1 - 3.0 / image.width), radius = std::hypot(x, y);
  if (radius > limit) x *= limit / radius, y *= limit / radius;
  const double px = std::clamp((x + 1) / 2 * image.width - 0.5, 0.0, image.width - 1.0);
  const double py = std::clamp((1 - y) / 2 * image.height - 0.5, 0.0, image.height - 1.0);
  const int x0 = int(px), y0 = int(py);
  const int x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
  const double fx = px - x0, fy = py - y0;
  for (int c = 0; c < 3; ++c) {
    sum[c] += (1 - fy) * ((1 - fx) * image.Pixel(x0, y0)[c] + fx * image.Pixel(x1, y0)[c]) +
              fy * ((1 - fx) * image.Pixel(x0, y1)[c] + fx * image.Pixel(x1, y1)[c]);
  }
}

Image FromAngular(const Image& angular) {
  constexpr int kSide = 4;  // samples along each side of a pixel
  Image latlong(std::max(angular.width, 2), std::max(angular.width / 2, 1));
  tbb::parallel_for(0, latlong.height, [&](int row) {
    for (int column = 0; column < latlong.width; ++column) {
      double sum[3] = {};
      for (int s = 0; s < kSide * kSide; ++s) {
        const double theta = kPi * (row + (s / kSide + 0.5) / kSide) / latlong.height;
        const double phi = 2 * kPi * ((column + (s % kSide + 0.5) / kSide) / latlong.width - 0.5);
        const double direction[3] = {std::sin(theta) * std::sin(phi),
                                     std::sin(theta) * std::cos(phi), std::cos(theta)};
        double x, y;
        AngularPosition(direction, x, y);
        AddAngularSample(angular, x, y, sum);
      }
      for (int c = 0; c < 3; ++c) {
        latlong.Pixel(column, row)[c] = float(sum[c] / (kSide * kSide));
      }
    }
  });
  return latlong;
}

}  // namespace

Projection DetectProjection(const Image& image, const std::string& path) {
  if (image.width == 2 * image.height) return Projection::kLatLong;
  if (image.width == image.height && image.width > 1) return Projection::kAngular;
  if (image.width == 1 && image.height == 1) return Projection::kLatLong;
  throw InputError(InputPosition::File(path),
                   fmt::format("{} x {} pixels are neither a lat-long map (2:1) nor an angular map "
                               "(square); say which with --env-projection latlong|angular",
                               image.width, image.height));
}

Image ToLatLong(Image image, Projection projection) {
  return projection == Projection::kAngular ? FromAngular(image) : std::move(image);
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
  // cos a - cos b = 2 sin((a + b) / 2) sin((b - a) / 2), which does not cancel.
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
