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
    const int finer = std::max((across - 1 + map.latlong->width) / map.latlong->width,
                               (across / 2 - 1 + map.latlong->height) / map.latlong->height);
    width_ = map.latlong->width * finer, height_ = map.latlong->height * finer;
    directions_.reserve(std::size_t(width_) * std::size_t(height_));
    solid_angles_.reserve(std::size_t(height_));
    // A direction is the sum of its parts along the axes of the map.
    const Vec forward = WorldDirection(map.map_from_world, 0.5, 0.5);
    const Vec right = WorldDirection(map.map_from_world, 0.75, 0.5);
    const Vec zenith = WorldDirection(map.map_from_world, 0.5, 0);
    std::vector<Vec> columns;
    for (int x = 0; x < width_; ++x) {
      const double turn = 2 * kPi * ((x + 0.5) / width_ - 0.5);
      columns.push_back(std::sin(turn) * right + std::cos(turn) * forward);
    }
    for (int y = 0; y < height_; ++y) {
      const double top = std::cos(kPi * y / height_), bottom = std::cos(kPi * (y + 1) / height_);
      const double up = (top + bottom) / 2, level = std::sqrt(1 - up * up);
      for (const Vec& column : columns) directions_.push_back(level * column + up * zenith);
      solid_angles_.push_back(2 * kPi / width_ * (top - bottom));
    }
  }
  std::size_t size() const { return directions_.size(); }
  const std::vector<Vec>& directions() const { return directions_; }
  double solid_angle(std::size_t cell) const { return solid_angles_[cell / std::size_t(width_)]; }

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
  std::vector<double> solid_angles_;  // of the cells of a row
};

}  // namespace skywave
