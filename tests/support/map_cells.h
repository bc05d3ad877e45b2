// Divides a map into directions for the midpoint rule over the sphere.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/support/adversarial_maps.h"

namespace skywave {

// The cells of a map, no larger than a texel and fine enough to integrate a cosine.
class MapCells {
 public:
  explicit MapCells(const EnvironmentMap& map, int across = 256) : map_(map) {
    const int finer = std::max((across - 1 + map.latlong.width) / map.latlong.width,
                               (across / 2 - 1 + map.latlong.height) / map.latlong.height);
    width_ = map.latlong.width * finer, height_ = map.latlong.height * finer;
    for (int y = 0; y < height_; ++y) {
      const double top = std::cos(kPi * y / height_), bottom = std::cos(kPi * (y + 1) / height_);
      const double v = std::acos((top + bottom) / 2) / kPi;
      for (int x = 0; x < width_; ++x) {
        directions_.push_back(WorldDirection(map.map_from_world, (x + 0.5) / width_, v));
        solid_angles_.push_back(2 * kPi / width_ * (top - bottom));
      }
    }
  }
  std::size_t size() const { return directions_.size(); }
  const std::vector<Vec>& directions() const { return directions_; }
  double solid_angle(std::size_t cell) const { return solid_angles_[cell]; }

  // Cells are grouped into at most 48 x 24 bins.
  static constexpr int kAcross = 48, kDown = 24;
  std::size_t Bin(int x, int y) const {
    return std::size_t(y * kDown / height_ * kAcross + x * kAcross / width_);
  }
  std::size_t BinOfCell(std::size_t cell) const {
    return Bin(int(cell) % width_, int(cell) / width_);
  }
  std::size_t BinOf(Vec direction) const {
    double u, v;
    MapPosition(map_.map_from_world, direction, u, v);
    return Bin(std::clamp(int(u * width_), 0, width_ - 1),
               std::clamp(int(v * height_), 0, height_ - 1));
  }

 private:
  const EnvironmentMap& map_;
  int width_, height_;
  std::vector<Vec> directions_;
  std::vector<double> solid_angles_;
};

}  // namespace skywave
