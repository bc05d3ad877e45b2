#include "wavefront/film.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skywave {
namespace {

constexpr double kSampleUnits = 0x1p52;  // doubles count units exactly up to here
constexpr double kHeadroom = 64;         // of a sample over the brightest texel

std::uint64_t SaturatingSum(std::uint64_t a, std::uint64_t b) {
  const std::uint64_t sum = a + b;
  return sum < a ? std::numeric_limits<std::uint64_t>::max() : sum;
}

}  // namespace

Film::Film(int width, int height, float brightest_radiance)
    : width_(width), height_(height), sums_(std::size_t(width) * height * 3) {
  int exponent = 0;
  if (brightest_radiance > 0) std::frexp(brightest_radiance * kHeadroom, &exponent);
  unit_ = std::ldexp(1 / kSampleUnits, std::max(exponent, 20));
}

void Film::Add(const PathColumns& paths, std::uint32_t n, RenderStats& stats) {
  const double scale = 1 / unit_;
  const auto limit = float(unit_ * kSampleUnits);
  for (std::uint32_t i = 0; i < n; ++i) {
    const float rgb[3] = {paths.r[i], paths.g[i], paths.b[i]};
    std::uint64_t* sum = &sums_[std::size_t(paths.pixel[i]) * 3];
    bool clamped = false, invalid = false;
    for (int c = 0; c < 3; ++c) {
      clamped |= rgb[c] > limit;
      invalid |= !(rgb[c] >= 0);
      // max and min in this order turn a NaN into 0.
      const double value = std::min(std::max(0.0f, rgb[c]), limit);
      sum[c] = SaturatingSum(sum[c], std::uint64_t(std::int64_t(value * scale)));
    }
    stats.clamped_samples += clamped;
    stats.invalid_samples += invalid;
  }
  stats.samples += n;
}

Image Film::Resolve(std::uint64_t samples) const {
  Image image(width_, height_);
  const double scale = unit_ / double(std::max<std::uint64_t>(samples, 1));
  std::transform(sums_.begin(), sums_.end(), image.rgb.begin(),
                 [&](std::uint64_t sum) { return float(double(sum) * scale); });
  return image;
}

}  // namespace skywave
