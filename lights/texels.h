// The packed form of a map that every lookup reads.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/environment.h"
#include "lights/environment_map.h"

namespace skywave {

// Radiance as halves with a common power of two, 11 bits a channel: exact for what comes from
// Radiance files and half EXRs, unless the map spans more than 2^40. Immutable once built.
class Texels {
 public:
  explicit Texels(const EnvironmentMap& map);

  // Luminance of a texel as the halves hold it.
  float Luminance(std::uint32_t column, std::uint32_t row) const;
  void SetMass(std::uint32_t column, std::uint32_t row, std::uint16_t mass);

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  std::size_t bytes() const { return records_.size() * sizeof(TexelRecord); }
  // Without densities; a strategy that has them adds its own.
  EnvironmentView view() const;

 private:
  std::uint32_t width_, height_;
  float scale_;
  std::array<float, 9> map_from_world_;
  std::vector<TexelRecord> records_;
};

}  // namespace skywave
