#include "lights/maps/sphere_map.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/large_memory.h"
#include "lights/maps/environment_map.h"

namespace skywave {
namespace {

// Returns the integral of sin^2 from a to a + h, without the cancellation of h/2 - (sin 2b - sin
// 2a) / 4 for narrow rows at the poles.
double SineSquareIntegral(double a, double h) {
  if (h < 0.01) {  // three-point Gauss-Legendre: error below h^7 / 1e4
    const double middle = a + h / 2, offset = h / 2 * std::sqrt(0.6);
    const auto square = [](double x) { return std::sin(x) * std::sin(x); };
    return h / 18 *
           (5 * square(middle - offset) + 8 * square(middle) + 5 * square(middle + offset));
  }
  return h / 2 - std::cos(2 * a + h) * std::sin(h) / 2;
}

bool IsRadiance(const float* rgb) {
  for (int c = 0; c < 3; ++c) {
    if (!(rgb[c] >= 0 && std::isfinite(rgb[c]))) return false;
  }
  return true;
}

void FillGeometry(SphereMap& map) {
  const double step = std::numbers::pi / map.height, column_step = 2 * std::numbers::pi / map.width;
  for (int y = 0; y < map.height; ++y) {
    const double top = y * step, middle = (y + 0.5) * step;
    map.solid_angle.push_back(RowSolidAngle(map.width, map.height, y));
    map.up_integral.push_back(column_step * std::sin(2 * middle) * std::sin(step) / 2);
    map.horizontal_integral.push_back(2 * std::sin(column_step / 2) *
                                      SineSquareIntegral(top, step));
    map.row_sine.push_back(std::sin(middle));
    map.row_cosine.push_back(std::cos(middle));
  }
  for (int x = 0; x < map.width; ++x) {
    const double phi = column_step * (x + 0.5 - map.width / 2.0);
    map.column_right.push_back(std::sin(phi));
    map.column_forward.push_back(std::cos(phi));
  }
}

}  // namespace

double SphereMap::AreaInPixels(double steradians) const {
  return steradians * width * height / (2 * std::numbers::pi * std::numbers::pi);
}

SphereMap MakeSphereMap(const Image& image) {
  if (image.width < 1 || image.height < 1) throw InputError({}, "the map has no pixels");
  SphereMap map;
  map.image = &image;
  map.width = image.width;
  map.height = image.height;
  ResizeLarge(map.luminance, std::size_t(map.width) * map.height);
  FillGeometry(map);

  std::vector<double> row_energy(map.height);
  std::atomic<bool> bad = false;
  tbb::parallel_for(0, map.height, [&](int y) {
    double sum = 0;
    for (int x = 0; x < map.width; ++x) {
      const float* rgb = image.Pixel(x, y);
      if (!IsRadiance(rgb)) bad = true;
      const float luminance = Luminance(rgb);
      map.luminance[std::size_t(y) * map.width + x] = luminance;
      sum += luminance;
    }
    row_energy[y] = sum * map.solid_angle[y];
  });
  if (bad) {
    throw InputError({}, "the map has pixels that are NaN, infinite or negative; repair it first");
  }
  for (double energy : row_energy) map.energy += energy;
  return map;
}

Vector3 DirectionOfUv(double u, double v) {
  const double theta = std::numbers::pi * v, phi = 2 * std::numbers::pi * (u - 0.5),
               sine = std::sin(theta);
  return {sine * std::sin(phi), sine * std::cos(phi), std::cos(theta)};
}

void UvOfDirection(const Vector3& direction, double& u, double& v) {
  u = 0.5 + std::atan2(direction.x, direction.y) / (2 * std::numbers::pi);
  if (u >= 1) u -= 1;
  v = std::atan2(std::hypot(direction.x, direction.y), direction.z) / std::numbers::pi;
}

std::size_t TexelOfUv(double u, double v, int width, int height) {
  const int column = std::clamp(int(u * width), 0, width - 1);
  const int row = std::clamp(int(v * height), 0, height - 1);
  return std::size_t(row) * width + column;
}

std::array<float, 3> WorldFromMap(const Vector3& d, const std::array<float, 9>& map_from_world) {
  std::array<float, 3> world;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // The rows are right, forward and up in the world.
    world[axis] = float(d.x * map_from_world[axis] + d.y * map_from_world[3 + axis] +
                        d.z * map_from_world[6 + axis]);
  }
  return world;
}

Vector3 MapFromWorld(const Vector3& d, const std::array<float, 9>& map_from_world) {
  const auto row = [&](std::size_t k) {
    return double(map_from_world[3 * k]) * d.x + double(map_from_world[3 * k + 1]) * d.y +
           double(map_from_world[3 * k + 2]) * d.z;
  };
  return {row(0), row(1), row(2)};
}

}  // namespace skywave
