#include "lights/tables/texels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "base/large_memory.h"

namespace skywave {
namespace {

constexpr int kMantissas = 1 << kMantissaBits;

float PowerOfTwo(int exponent) {  // in [-126, 127]
  return std::bit_cast<float>(std::uint32_t(exponent + 127) << 23);
}

// Rounds down, so that the loss is never negative. All factors are powers of two, so the mantissas
// are the only rounding.
PackedRadiance Pack(const float* rgb, float inverse_unit) {
  const float brightest = std::max({rgb[0], rgb[1], rgb[2]}) * inverse_unit;
  // The exponent field less 126 is the e of frexp: brightest < 2^e.
  const int exponent =
      std::clamp(int(std::bit_cast<std::uint32_t>(brightest) >> 23) - 126 - int(kMantissaBits),
                 -int(kMaxExponent), 0);
  const float scale = inverse_unit * PowerOfTwo(-exponent);
  PackedRadiance packed = std::uint32_t(exponent + int(kMaxExponent)) << 3 * kMantissaBits;
  for (int c = 0; c < 3; ++c) {
    const auto mantissa = std::uint32_t(rgb[c] * scale);
    packed |= std::min<std::uint32_t>(mantissa, kMantissas - 1) << kMantissaBits * c;
  }
  return packed;
}

void Unpack(PackedRadiance packed, float unit, float* rgb) {
  const float scale = unit * PowerOfTwo(int(packed >> 3 * kMantissaBits) - int(kMaxExponent));
  for (int c = 0; c < 3; ++c) {
    rgb[c] = float(packed >> kMantissaBits * c & (kMantissas - 1)) * scale;
  }
}

// Returns the least exponent field of texels that `lost` changes nothing of: its channels are less
// than the last bit of a mantissa, by more than their sum can be rounded.
std::uint32_t KeepingExponent(const float* lost, float inverse_unit) {
  constexpr std::uint32_t kNone = 1u << (32 - 3 * kMantissaBits);
  if (!(std::min({lost[0], lost[1], lost[2]}) >= 0)) return kNone;
  const float most = std::max({lost[0], lost[1], lost[2]}) * inverse_unit * (1 + 0x1p-10f);
  if (!(most < 1)) return kNone;
  // most < 2^e, and the last bit of an exponent field x is 2^(x - kMaxExponent).
  const int e = int(std::bit_cast<std::uint32_t>(most) >> 23) - 126;
  return std::uint32_t(std::max(e + int(kMaxExponent), 0));
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
    : width_(std::uint32_t(map.latlong->width)),
      height_(std::uint32_t(map.latlong->height)),
      lines_per_row_((width_ + kLineTexels - 1) / kLineTexels),
      map_from_world_(map.map_from_world),
      image_(map.latlong),
      row_area_(height_) {
  ResizeLarge(lines_, std::size_t(lines_per_row_) * height_);
  for (std::uint32_t row = 0; row < height_; ++row) row_area_[row] = AreaOfRow(row, height_);
  const float brightest = *std::max_element(light.rgb.begin(), light.rgb.end());
  int exponent = 0;
  if (brightest > 0) std::frexp(brightest, &exponent);
  // There is room for a unit above the brightest texel, which takes what its neighbours hand on.
  if (std::ldexp(double(brightest), int(kMantissaBits) - exponent) > kMantissas - 2) ++exponent;
  unit_ = std::ldexp(1.0f, std::clamp(exponent - int(kMantissaBits), -90, 119));
  const float most = unit_ * float(kMantissas - 1);
  // The loss of a texel by rounding is handed to the next, so that energy is kept: a bright texel
  // is off by some thousandths of itself, which would show in the light of the whole map. Rounding
  // is downwards, so nothing is ever taken from a texel: a sun spills over but never darkens its
  // neighbours.
  const float inverse_unit = 1 / unit_;
  // Packs `wanted` and adds the part that does not fit to `lost`.
  const auto pack = [&](PackedRadiance& texel, const float* wanted, float* lost) {
    float room[3], held[3];
    for (int c = 0; c < 3; ++c) room[c] = std::clamp(wanted[c] + lost[c], 0.0f, most);
    texel = Pack(room, inverse_unit);
    Unpack(texel, unit_, held);
    for (int c = 0; c < 3; ++c) lost[c] += wanted[c] - held[c];
  };
  std::vector<std::array<float, 3>> handed_on(height_);
  tbb::parallel_for(0u, height_, [&](std::uint32_t row) {
    handed_on[row] = {};
    for (std::uint32_t i = 0; i < width_; ++i) {
      pack(packed(i, row), light.Pixel(int(i), int(row)), handed_on[row].data());
    }
  });
  // The end of a row hands its loss on to the beginning of the next, where a few texels take it.
  const float nothing = 1e-6f * unit_;
  for (std::uint32_t row = 1; row < height_; ++row) {
    const double ratio = RowSolidAngle(int(width_), int(height_), int(row) - 1) /
                         RowSolidAngle(int(width_), int(height_), int(row));
    std::array<float, 3> lost = handed_on[row - 1];
    for (float& channel : lost) channel *= float(ratio);
    std::uint32_t keeping = KeepingExponent(lost.data(), inverse_unit);
    for (std::uint32_t i = 0; i < width_; ++i) {
      if (std::max({lost[0], lost[1], lost[2]}) <= nothing) break;
      // Most texels are too bright to take anything.
      while (i < width_ && packed(i, row) >> 3 * kMantissaBits >= keeping) ++i;
      if (i == width_) break;
      float held[3];
      Unpack(packed(i, row), unit_, held);
      pack(packed(i, row), held, lost.data());
      keeping = KeepingExponent(lost.data(), inverse_unit);
    }
    for (int c = 0; c < 3; ++c) handed_on[row][c] += lost[c];
  }
}

float Texels::Luminance(std::uint32_t column, std::uint32_t row) const {
  float rgb[3];
  Unpack(packed(column, row), unit_, rgb);
  return skywave::Luminance(rgb);
}

Image Texels::Held() const {
  Image held(static_cast<int>(width_), static_cast<int>(height_));
  for (std::uint32_t row = 0; row < height_; ++row) {
    for (std::uint32_t i = 0; i < width_; ++i) {
      Unpack(packed(i, row), unit_, held.Pixel(int(i), int(row)));
    }
  }
  return held;
}

EnvironmentView Texels::view(const std::array<float, 9>& map_from_world) const {
  EnvironmentView view = {.texels = lines_.data(),
                          .radiance_unit = unit_,
                          .rgb = image_->rgb.data(),
                          .width = width_,
                          .height = height_,
                          .lines = lines_per_row_,
                          .map_from_world = {},
                          .row_area = row_area_.data()};
  std::copy(map_from_world.begin(), map_from_world.end(), view.map_from_world);
  return view;
}

}  // namespace skywave
