#include "lights/texels.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace skywave {
namespace {

// Rounds a value in [0, 65504] to the nearest half, ties to even.
std::uint16_t ToHalf(float value) {
  if (value < 0x1p-14f) return std::uint16_t(std::lrint(value * 0x1p24f));
  std::uint32_t bits = std::bit_cast<std::uint32_t>(std::min(value, 65504.0f));
  bits += 0xFFFu + (bits >> 13 & 1u);
  return std::uint16_t((bits >> 13) - (112u << 10));
}

float FromHalf(std::uint16_t half) {
  if (half < 1u << 10) return float(half) * 0x1p-24f;
  return std::bit_cast<float>((std::uint32_t(half) << 13) + (112u << 23));
}

}  // namespace

Texels::Texels(const EnvironmentMap& map)
    : width_(std::uint32_t(map.latlong.width)),
      height_(std::uint32_t(map.latlong.height)),
      map_from_world_(map.map_from_world),
      records_(std::size_t(width_) * height_) {
  const std::vector<float>& rgb = map.latlong.rgb;
  const float brightest = *std::max_element(rgb.begin(), rgb.end());
  int exponent = 0;
  if (brightest > 0) std::frexp(brightest, &exponent);
  scale_ = std::ldexp(1.0f, std::clamp(exponent - 15, -120, 112));  // brightest: [2^14, 2^15)
  const float inverse = 1 / scale_;
  for (std::size_t i = 0; i < records_.size(); ++i) {
    records_[i] = {ToHalf(rgb[3 * i] * inverse), ToHalf(rgb[3 * i + 1] * inverse),
                   ToHalf(rgb[3 * i + 2] * inverse), 0};
  }
}

float Texels::Luminance(std::uint32_t column, std::uint32_t row) const {
  const TexelRecord& record = records_[std::size_t(row) * width_ + column];
  const float rgb[3] = {FromHalf(record.r), FromHalf(record.g), FromHalf(record.b)};
  return skywave::Luminance(rgb) * scale_;
}

void Texels::SetMass(std::uint32_t column, std::uint32_t row, std::uint16_t mass) {
  records_[std::size_t(row) * width_ + column].mass = mass;
}

EnvironmentView Texels::view() const {
  EnvironmentView view = {.texels = records_.data(),
                          .width = width_,
                          .height = height_,
                          .radiance_scale = scale_,
                          .map_from_world = {},
                          .block_density = nullptr,
                          .blocks = (width_ + kNodeFan - 1) / kNodeFan};
  std::copy(map_from_world_.begin(), map_from_world_.end(), view.map_from_world);
  return view;
}

}  // namespace skywave
