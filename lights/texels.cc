#include "lights/texels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {
namespace {

constexpr int kMantissas = 1 << kMantissaBits;

// Radiance in units in which the brightest texel of the map is in [kMantissas / 2, kMantissas).
// Rounds down: what is lost is never negative.
PackedRadiance Pack(const float* rgb, double inverse_unit) {
  const double brightest = std::max({rgb[0], rgb[1], rgb[2]}) * inverse_unit;
  int exponent = 0;
  std::frexp(brightest, &exponent);  // brightest < 2^exponent
  exponent = std::clamp(exponent - int(kMantissaBits), -int(kMaxExponent), 0);
  PackedRadiance packed = std::uint32_t(exponent + int(kMaxExponent)) << 3 * kMantissaBits;
  for (int c = 0; c < 3; ++c) {
    const auto mantissa = std::uint32_t(std::ldexp(rgb[c] * inverse_unit, -exponent));
    packed |= std::min<std::uint32_t>(mantissa, kMantissas - 1) << kMantissaBits * c;
  }
  return packed;
}

void Unpack(PackedRadiance packed, float unit, float* rgb) {
  const int exponent = int(packed >> 3 * kMantissaBits) - int(kMaxExponent);
  for (int c = 0; c < 3; ++c) {
    const std::uint32_t mantissa = packed >> kMantissaBits * c & (kMantissas - 1);
    rgb[c] = std::ldexp(float(mantissa) * unit, exponent);
  }
}

RowArea AreaOfRow(std::uint32_t row, std::uint32_t height) {
  const auto square = [](double x) { return x * x; };
  const double top = std::numbers::pi / 2 * row / height;
  const double bottom = std::numbers::pi / 2 * (row + 1) / height;
  const bool north = row < (height + 1) / 2;
  const double start = square(north ? std::sin(top) : std::cos(top));
  const double end = square(north ? std::sin(bottom) : std::cos(bottom));
  return {float(start), float(end - start)};
}

}  // namespace

Texels::Texels(const EnvironmentMap& map, const Image& light)
    : width_(std::uint32_t(map.latlong.width)),
      height_(std::uint32_t(map.latlong.height)),
      map_from_world_(map.map_from_world),
      packed_(std::size_t(width_) * height_),
      rgb_(map.latlong.rgb),
      row_area_(height_) {
  for (std::uint32_t row = 0; row < height_; ++row) row_area_[row] = AreaOfRow(row, height_);
  const float brightest = *std::max_element(light.rgb.begin(), light.rgb.end());
  int exponent = 0;
  if (brightest > 0) std::frexp(brightest, &exponent);
  // Room for a unit above the brightest texel, which takes what its neighbours hand on.
  if (std::ldexp(double(brightest), int(kMantissaBits) - exponent) > kMantissas - 2) ++exponent;
  unit_ = std::ldexp(1.0f, std::clamp(exponent - int(kMantissaBits), -90, 119));
  const float most = unit_ * float(kMantissas - 1);
  // What a texel loses by rounding is handed to the next, so that energy is kept: a bright texel is
  // off by some thousandths of itself, which would show in the light of the whole map. Rounding is
  // down, so nothing is ever taken from a texel: a sun spills over, it casts no darkness.
  float lost[3] = {};
  double solid_angle = 1;
  for (std::uint32_t row = 0; row < height_; ++row) {
    const double next_solid_angle = RowSolidAngle(int(width_), int(height_), int(row));
    for (float& channel : lost) channel *= float(solid_angle / next_solid_angle);
    solid_angle = next_solid_angle;
    for (std::uint32_t column = 0; column < width_; ++column) {
      const std::size_t i = std::size_t(row) * width_ + column;
      float wanted[3], held[3];
      for (int c = 0; c < 3; ++c)
        wanted[c] = std::clamp(light.rgb[3 * i + c] + lost[c], 0.0f, most);
      packed_[i] = Pack(wanted, 1.0 / unit_);
      Unpack(packed_[i], unit_, held);
      for (int c = 0; c < 3; ++c) lost[c] += light.rgb[3 * i + c] - held[c];
    }
  }
}

float Texels::Luminance(std::uint32_t column, std::uint32_t row) const {
  float rgb[3];
  Unpack(packed_[std::size_t(row) * width_ + column], unit_, rgb);
  return skywave::Luminance(rgb);
}

Image Texels::Held() const {
  Image held(static_cast<int>(width_), static_cast<int>(height_));
  for (std::size_t i = 0; i < packed_.size(); ++i) Unpack(packed_[i], unit_, &held.rgb[3 * i]);
  return held;
}

EnvironmentView Texels::view() const {
  EnvironmentView view = {.packed = packed_.data(),
                          .radiance_unit = unit_,
                          .rgb = rgb_.data(),
                          .width = width_,
                          .height = height_,
                          .map_from_world = {},
                          .row_area = row_area_.data()};
  std::copy(map_from_world_.begin(), map_from_world_.end(), view.map_from_world);
  return view;
}

}  // namespace skywave
