// A pyramid of maxima bounds the largest value of an image over any rectangle in constant time.
#pragma once

#include <vector>

#include "lights/tables/summed_area_table.h"

namespace skywave {

// Level k holds the maxima of squares of 2^k x 2^k texels; level 0 is the image itself.
struct MaxPyramid {
  struct Level {
    int width, height;
    std::vector<float> value;
  };
  std::vector<Level> levels;
  double sum = 0;  // sum over level 0

  int width() const { return levels[0].width; }
  int height() const { return levels[0].height; }
  float At(int x, int y) const { return levels[0].value[std::size_t(y) * width() + x]; }
  float maximum() const { return levels.back().value[0]; }

  // Returns a bound that is not less than any texel of the rectangle, and is the value of some
  // texel less than one rectangle's side away; the part outside the image counts as 0. Reads up to
  // 3 x 3 values.
  float Bound(const Region& rectangle) const;
};

// `values` has width * height entries. Throws InputError if any is negative or not finite.
MaxPyramid MakeMaxPyramid(int width, int height, std::vector<float> values);

// Returns the importance of texels for samplers in the plane of the map: luminance times the exact
// solid angle of the texel, relative to that of the middle row.
MaxPyramid ImportancePyramid(const SphereMap& map);
// The same of the luminance alone, as if the map were a plane: samples of it crowd at the poles of
// the sphere (T figure 5.4a).
MaxPyramid PlanePyramid(const SphereMap& map);

}  // namespace skywave
