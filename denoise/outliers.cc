#include "denoise/outliers.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

namespace skywave {
namespace {

// A half pixel is an outlier if it is this many times as bright as anything that the other half has
// in the pixels around, and this many standard deviations brighter.
constexpr float kTimesBrighter = 4, kDeviations = 4;
// Its excess is spread by two means over this many pixels on each side, one after the other.
constexpr int kSpread = 20;
// Everything gets a share, at least this one.
constexpr float kLeastShare = 1e-3f;

float Brightness(const HalfPlanes& half, std::size_t at) {
  return half.r[at] + half.g[at] + half.b[at];
}

// The largest brightness and noise of the 3 x 3 pixels around one.
struct Surroundings {
  float brightness = 0, noise = 0;
};
Surroundings Around(const PlaneShape& shape, const HalfPlanes& half, int x, int y) {
  Surroundings most;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const std::size_t at = shape.at(x + dx, y + dy);
      most.brightness = std::max(most.brightness, Brightness(half, at));
      most.noise = std::max(most.noise, half.noise[at]);
    }
  }
  return most;
}

bool IsOutlier(float brightness, const Surroundings& others) {
  return brightness > kTimesBrighter * others.brightness &&
         brightness > others.brightness + kDeviations * std::sqrt(others.noise);
}

// Replaces `line`, `count` values `step` apart, by means over 2 * kSpread + 1 of them. The line is
// mirrored at its ends, so its sum stays.
void MeanOfLine(float* line, int count, std::size_t step, std::vector<double>& sums) {
  const auto mirrored = [&](int i) {
    const int period = 2 * count;
    i = ((i % period) + period) % period;
    return i < count ? i : period - 1 - i;
  };
  sums.assign(std::size_t(count), 0);
  double sum = 0;
  for (int i = -kSpread; i <= kSpread; ++i) sum += line[std::size_t(mirrored(i)) * step];
  for (int i = 0; i < count; ++i) {
    sums[std::size_t(i)] = sum;
    sum += double(line[std::size_t(mirrored(i + kSpread + 1)) * step]) -
           line[std::size_t(mirrored(i - kSpread)) * step];
  }
  for (int i = 0; i < count; ++i) {
    line[std::size_t(i) * step] = float(std::max(sums[std::size_t(i)], 0.0) / (2 * kSpread + 1));
  }
}

void Spread(const PlaneShape& shape, float* plane) {
  for (int pass = 0; pass < 2; ++pass) {
    tbb::parallel_for(0, shape.height, [&](int y) {
      std::vector<double> sums;
      MeanOfLine(plane + shape.at(0, y), shape.width, 1, sums);
    });
    tbb::parallel_for(0, shape.width, [&](int x) {
      std::vector<double> sums;
      MeanOfLine(plane + shape.at(x, 0), shape.height, shape.pitch(), sums);
    });
  }
}

// How much of an excess a pixel takes: what it reflects.
float ShareOf(const DenoiserPlanes& planes, const DenoiserInput& input, int x, int y) {
  const std::size_t at = planes.shape.at(x, y);
  const std::size_t pixel = std::size_t(y) * std::size_t(input.image.width) + std::size_t(x);
  const float texture = planes.texture->r[at] + planes.texture->g[at] + planes.texture->b[at];
  return std::max(input.coverage[pixel] * texture, kLeastShare);
}

}  // namespace

OutlierExcess TakeOutliers(const DenoiserInput& input, DenoiserPlanes& planes) {
  const PlaneShape& shape = planes.shape;
  std::atomic<std::uint64_t> outliers = 0;
  soa::Table<TexturePlanes> excess(std::uint32_t(shape.size()));
  // The halves are tested as they were read, whatever has been taken out of the pixels above.
  soa::Table<HalfPlanes> taken[2] = {soa::Table<HalfPlanes>(std::uint32_t(shape.size())),
                                     soa::Table<HalfPlanes>(std::uint32_t(shape.size()))};
  tbb::parallel_for(0, shape.height, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      const std::size_t at = shape.at(x, y);
      for (int h = 0; h < 2; ++h) {
        const HalfPlanes &half = planes.halves[h], &kept = taken[h];
        kept.r[at] = half.r[at], kept.g[at] = half.g[at], kept.b[at] = half.b[at];
        kept.noise[at] = half.noise[at];
        const float brightness = Brightness(half, at);
        const Surroundings others = Around(shape, planes.halves[1 - h], x, y);
        if (!IsOutlier(brightness, others)) continue;
        outliers.fetch_add(1, std::memory_order_relaxed);
        const std::size_t pixel = std::size_t(y) * std::size_t(shape.width) + std::size_t(x);
        const float second = input.half_samples[pixel] / input.samples[pixel];
        const float left = others.brightness / brightness, share = h == 0 ? 1 - second : second;
        excess->r[at] += (1 - left) * share * half.r[at] * planes.texture->r[at];
        excess->g[at] += (1 - left) * share * half.g[at] * planes.texture->g[at];
        excess->b[at] += (1 - left) * share * half.b[at] * planes.texture->b[at];
        kept.r[at] *= left, kept.g[at] *= left, kept.b[at] *= left;
        kept.noise[at] = others.noise;
      }
    }
  });
  OutlierExcess result = {.outliers = outliers, .spread = {}};
  if (result.outliers == 0) return result;
  // Pixel i gives to pixel j in proportion to the share of j. The mean is symmetric, so what i
  // gives adds up to its excess.
  soa::Table<TexturePlanes> shares(std::uint32_t(shape.size()));
  const auto for_each_pixel = [&](const auto& f) {
    tbb::parallel_for(0, shape.height, [&](int y) {
      for (int x = 0; x < shape.width; ++x) f(x, y, shape.at(x, y));
    });
  };
  for_each_pixel([&](int x, int y, std::size_t at) {
    shares->r[at] = shares->g[at] = ShareOf(planes, input, x, y);
  });
  Spread(shape, shares->r);
  for_each_pixel([&](int, int, std::size_t at) {
    const float scale = 1 / shares->r[at];
    excess->r[at] *= scale, excess->g[at] *= scale, excess->b[at] *= scale;
  });
  for (float* plane : {excess->r, excess->g, excess->b}) Spread(shape, plane);
  for_each_pixel([&](int, int, std::size_t at) {
    const float share = shares->g[at];
    excess->r[at] *= share, excess->g[at] *= share, excess->b[at] *= share;
  });
  for (int h = 0; h < 2; ++h) planes.halves[h] = std::move(taken[h]);
  result.spread = std::move(excess);
  return result;
}

}  // namespace skywave
