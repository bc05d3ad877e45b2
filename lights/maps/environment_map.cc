#include "lights/maps/environment_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

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
