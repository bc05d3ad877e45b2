#include "lights/texels.h"

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

constexpr int kMantissas = 1 << kMantissaBits;

// Radiance in units in which the brightest texel of the map is in [kMantissas / 2, kMantissas).
PackedRadiance Pack(const float* rgb, double inverse_unit) {
  const double brightest = std::max({rgb[0], rgb[1], rgb[2]}) * inverse_unit;
  int exponent = 0;
  std::frexp(brightest, &exponent);  // brightest < 2^exponent
  exponent = std::max(exponent - int(kMantissaBits), -int(kMaxExponent));
  // Rounding may lift the largest mantissa to 2^9: then all lose a bit.
  if (std::lround(std::ldexp(brightest, -exponent)) >= kMantissas) ++exponent;
  PackedRadiance packed = std::uint32_t(std::min(exponent, 0) + int(kMaxExponent))
                          << 3 * kMantissaBits;
  for (int c = 0; c < 3; ++c) {
    const long mantissa = std::lround(std::ldexp(rgb[c] * inverse_unit, -std::min(exponent, 0)));
    packed |= std::uint32_t(std::min<long>(mantissa, kMantissas - 1)) << kMantissaBits * c;
  }
  return packed;
}

}  // namespace

Texels::Texels(const EnvironmentMap& map)
    : width_(std::uint32_t(map.latlong.width)),
      height_(std::uint32_t(map.latlong.height)),
      map_from_world_(map.map_from_world),
      packed_(std::size_t(width_) * height_),
      rgb_(map.latlong.rgb) {
  const float brightest = *std::max_element(rgb_.begin(), rgb_.end());
  int exponent = 0;
  if (brightest > 0) std::frexp(brightest, &exponent);
  // One unit finer would let the brightest texel itself round up to 2^9.
  if (std::lround(std::ldexp(double(brightest), int(kMantissaBits) - exponent)) >= kMantissas) {
    ++exponent;
  }
  unit_ = std::ldexp(1.0f, std::clamp(exponent - int(kMantissaBits), -90, 110));
  for (std::size_t i = 0; i < packed_.size(); ++i) packed_[i] = Pack(&rgb_[3 * i], 1.0 / unit_);
}

float Texels::Luminance(std::uint32_t column, std::uint32_t row) const {
  const PackedRadiance packed = packed_[std::size_t(row) * width_ + column];
  const int exponent = int(packed >> 3 * kMantissaBits) - int(kMaxExponent);
  float rgb[3];
  for (int c = 0; c < 3; ++c) {
    const std::uint32_t mantissa = packed >> kMantissaBits * c & (kMantissas - 1);
    rgb[c] = std::ldexp(float(mantissa) * unit_, exponent);
  }
  return skywave::Luminance(rgb);
}

EnvironmentView Texels::view() const {
  EnvironmentView view = {.packed = packed_.data(),
                          .radiance_unit = unit_,
                          .rgb = rgb_.data(),
                          .width = width_,
                          .height = height_,
                          .map_from_world = {}};
  std::copy(map_from_world_.begin(), map_from_world_.end(), view.map_from_world);
  return view;
}

}  // namespace skywave
