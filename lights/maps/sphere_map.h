// A sphere map is a lat-long map as light on the sphere: all builders of samples, cells and lights
// read it.
//
// Radiance is constant inside a texel. Directions are in map space (right, forward, up) with u =
// 1/2 + atan2(right, forward) / 2 pi, v = acos(up) / pi, as kernels/lights/environment.h has them.
// All integrals over texels are exact, so rows add up to 4 pi and no pole needs special care.
// Units: radiance is that of the image, energy is luminance integrated over solid angle.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "image/image.h"
#include "lights/vector3.h"

namespace skywave {

struct SphereMap {
  const Image* image = nullptr;  // borrowed; must outlive the map
  int width = 0, height = 0;
  std::vector<float> luminance;  // width * height
  double energy = 0;             // sum of luminance * solid angle

  // Solid angle of one texel of row j [sr], and the integrals of up and of the horizontal part over
  // it; the horizontal part points to the texel's middle column.
  std::vector<double> solid_angle, up_integral, horizontal_integral;
  // Middle of column i: right and forward parts of a horizontal unit vector.
  std::vector<double> column_right, column_forward;
  // Centre of row j: sine and cosine of the angle from the zenith.
  std::vector<double> row_sine, row_cosine;

  std::size_t texels() const { return luminance.size(); }
  double Energy(int x, int y) const {
    return luminance[std::size_t(y) * width + x] * solid_angle[y];
  }
  // Returns the integral of direction over texel (x, y) [sr], parallel to its area-weighted mean
  // direction.
  Vector3 DirectionIntegral(int x, int y) const {
    return {horizontal_integral[y] * column_right[x], horizontal_integral[y] * column_forward[x],
            up_integral[y]};
  }
  Vector3 TexelCentre(int x, int y) const {
    return {row_sine[y] * column_right[x], row_sine[y] * column_forward[x], row_cosine[y]};
  }
  // Returns a solid angle as what the thesis calls spherical area in pixels: the whole map has 2 W
  // H / pi (T 7.13).
  double AreaInPixels(double steradians) const;
};

// Throws InputError if the image is empty or has a pixel that is not a radiance (NaN, infinite or
// negative: see RepairRadiance). A black map is fine; its energy is 0.
SphereMap MakeSphereMap(const Image& image);

// These convert (u, v) in [0, 1]^2 to a unit vector, and back with u in [0, 1).
Vector3 DirectionOfUv(double u, double v);
void UvOfDirection(const Vector3& direction, double& u, double& v);
// Returns the texel, counted row by row, that has (u, v) in a map of this size.
std::size_t TexelOfUv(double u, double v, int width, int height);

// Turns a direction of map space into world space, and back.
std::array<float, 3> WorldFromMap(const Vector3& direction,
                                  const std::array<float, 9>& map_from_world);
Vector3 MapFromWorld(const Vector3& direction, const std::array<float, 9>& map_from_world);

}  // namespace skywave
