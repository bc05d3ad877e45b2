#include "lights/maps/sum_maps.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lights/maps/projections.h"
#include "lights/vector3.h"

namespace skywave {
namespace {

// Reads a lat-long map between the centres of its pixels, across its seam; rows end at the poles.
std::array<double, 3> Interpolate(const Image& map, const ImagePoint& at) {
  const double x = at.u * map.width - 0.5, y = at.v * map.height - 0.5;
  const int column = int(std::floor(x)), row = int(std::floor(y));
  std::array<double, 3> sum = {};
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double weight = std::abs(1 - i - (x - column)) * std::abs(1 - j - (y - row));
      const float* rgb =
          map.Pixel((column + i + map.width) % map.width, std::clamp(row + j, 0, map.height - 1));
      for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * double(rgb[c]);
    }
  }
  return sum;
}

using Matrix3 = std::array<std::array<double, 3>, 3>;  // columns

// Turns directions of the space of `from` into the space of `to`.
Matrix3 Rotation(const OrientedMap& to, const OrientedMap& from) {
  Matrix3 rotation = {};
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t k = 0; k < 3; ++k) {
        rotation[column][row] +=
            double(to.world_from_map[row][k]) * double(from.world_from_map[column][k]);
      }
    }
  }
  return rotation;
}

Vector3 Turn(const Matrix3& m, const Vector3& d) {
  return {m[0][0] * d.x + m[1][0] * d.y + m[2][0] * d.z,
          m[0][1] * d.x + m[1][1] * d.y + m[2][1] * d.z,
          m[0][2] * d.x + m[1][2] * d.y + m[2][2] * d.z};
}

// Returns `map` on the grid and in the frame of `grid`.
Image OnGridOf(const OrientedMap& grid, const OrientedMap& map) {
  Image image(grid.latlong.width, grid.latlong.height);
  const Matrix3 rotation = Rotation(map, grid);
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      std::array<double, 3> sum = {};
      for (int point = 0; point < 4; ++point) {
        const ImagePoint at = {(x + 0.25 + 0.5 * (point % 2)) / image.width,
                               (y + 0.25 + 0.5 * (point / 2)) / image.height};
        const Vector3 to = Turn(rotation, *DirectionOfPoint(Projection::kLatLong, at));
        const auto value = Interpolate(map.latlong, PointOfDirection(Projection::kLatLong, to));
        for (std::size_t c = 0; c < 3; ++c) sum[c] += value[c];
      }
      for (std::size_t c = 0; c < 3; ++c) image.Pixel(x, y)[c] = float(sum[c] / 4);
    }
  });
  const std::array<double, 3> wanted = SphereMean(map.latlong), found = SphereMean(image);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    if (found[i % 3] > 0) image.rgb[i] *= float(wanted[i % 3] / found[i % 3]);
  }
  return image;
}

std::size_t Texels(const OrientedMap& map) { return map.latlong.rgb.size(); }

}  // namespace

OrientedMap SumMaps(std::vector<OrientedMap> maps) {
  const auto finest = std::max_element(
      maps.begin(), maps.end(), [](const auto& a, const auto& b) { return Texels(a) < Texels(b); });
  OrientedMap sum = *finest;
  for (auto map = maps.begin(); map != maps.end(); ++map) {
    if (map == finest) continue;
    const bool same = Texels(*map) == Texels(sum) && map->latlong.width == sum.latlong.width &&
                      map->world_from_map == sum.world_from_map;
    const bool constant = Texels(*map) == 3;
    const Image image = same || constant ? map->latlong : OnGridOf(sum, *map);
    const std::size_t period = image.rgb.size();
    for (std::size_t i = 0; i < sum.latlong.rgb.size(); ++i) {
      float& value = sum.latlong.rgb[i];
      value = std::min(value + image.rgb[i % period], std::numeric_limits<float>::max());
    }
  }
  return sum;
}

}  // namespace skywave
