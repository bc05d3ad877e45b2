// A map in the two forms that lookups read: packed where it acts as a light, in full precision
// where it is seen.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/lights/environment.h"
#include "lights/maps/environment_map.h"

namespace skywave {

// It keeps the map's image, because its pixels are what is seen. Packing rounds each channel down
// to 9 bits of the brightest channel of its texel (exact for Radiance files) and hands the loss on
// to the next texel, so the light of a map is kept. Texels dimmer than 2^-40 of the brightest
// become black as lights.
class Texels {
 public:
  explicit Texels(const EnvironmentMap& map) : Texels(map, map.latlong) {}
  // Only `light` acts as a light, a picture of the map's size: the rest of a map after directional
  // lights have been taken out.
  Texels(const EnvironmentMap& map, const Image& light);

  // Returns the luminance of a texel as the packed form holds it, which light samples find there.
  float Luminance(std::uint32_t column, std::uint32_t row) const;

  // Returns the map that light samples and escaped rays with a density see.
  Image Held() const;

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  float unit() const { return unit_; }
  std::size_t bytes() const { return lines_.size() * sizeof(TexelLine); }
  EnvironmentView view() const { return view(map_from_world_); }
  // The same for another orientation of the map: nothing else depends on it.
  EnvironmentView view(const std::array<float, 9>& map_from_world) const;

  // Lines lie row after row; an inversion writes their densities and shares, once.
  std::uint32_t lines_per_row() const { return lines_per_row_; }
  std::vector<TexelLine>& lines() { return lines_; }

 private:
  const PackedRadiance& packed(std::uint32_t column, std::uint32_t row) const {
    return lines_[std::size_t(row) * lines_per_row_ + column / kLineTexels]
        .texel[column % kLineTexels];
  }
  PackedRadiance& packed(std::uint32_t column, std::uint32_t row) {
    return const_cast<PackedRadiance&>(std::as_const(*this).packed(column, row));
  }

  std::uint32_t width_, height_, lines_per_row_;
  float unit_;
  std::array<float, 9> map_from_world_;
  std::vector<TexelLine> lines_;
  SharedImage image_;  // of the map
  std::vector<RowArea> row_area_;
};

}  // namespace skywave
