#include "wavefront/film.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "kernels/accumulate.h"

namespace skywave {
namespace {

constexpr double kSampleUnits = 0x1p52;  // doubles count units exactly up to here
constexpr double kHeadroom = 64;         // of a sample over the brightest texel

}  // namespace

Film::Film(int width, int height, float brightest_radiance)
    : width_(width), height_(height), sums_(std::size_t(width) * height * 3) {
  int exponent = 0;
  if (brightest_radiance > 0) std::frexp(brightest_radiance * kHeadroom, &exponent);
  unit_ = std::ldexp(1 / kSampleUnits, std::max(exponent, 20));
}

void Film::Add(const PathColumns& paths, std::uint32_t n, RenderStats& stats) {
  const FilmScale scale = {.units = 1 / unit_, .limit = float(unit_ * kSampleUnits)};
  const FilmCounts counts = AddToFilm(paths, n, scale, sums_.data());
  stats.clamped_samples += counts.clamped;
  stats.invalid_samples += counts.invalid;
  stats.samples += n;
}

void Film::Merge(const Film& other) {
  assert(sums_.size() == other.sums_.size() && unit_ == other.unit_);
  std::transform(sums_.begin(), sums_.end(), other.sums_.begin(), sums_.begin(),
                 [](std::uint64_t a, std::uint64_t b) {
                   const std::uint64_t sum = a + b;
                   return sum < a ? std::numeric_limits<std::uint64_t>::max() : sum;
                 });
}

Image Film::Resolve(std::uint64_t samples) const {
  Image image(width_, height_);
  const double scale = unit_ / double(std::max<std::uint64_t>(samples, 1));
  std::transform(sums_.begin(), sums_.end(), image.rgb.begin(),
                 [&](std::uint64_t sum) { return float(double(sum) * scale); });
  return image;
}

}  // namespace skywave
