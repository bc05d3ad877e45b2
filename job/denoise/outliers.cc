#include "job/denoise/outliers.h"

#include <tbb/parallel_for.h>

#include <algorithm>
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

// Replaces each of kLines lines that lie side by side, `count` values `step` apart, by means over
// 2 * kSpread + 1 of them. A line is mirrored at its ends, so its sum stays.
template <std::size_t kLines>
void MeanOfLines(float* lines, int count, std::size_t step) {
  const auto value = [&](int i) {
    if (i < 0 || i >= count) {
      const int period = 2 * count;
      i = ((i % period) + period) % period;
      i = i < count ? i : period - 1 - i;
    }
    return lines + std::size_t(i) * step;
  };
  std::vector<double> sums(std::size_t(count) * kLines);
  double sum[kLines] = {};
  for (int i = -kSpread; i <= kSpread; ++i) {
    for (std::size_t l = 0; l < kLines; ++l) sum[l] += value(i)[l];
  }
  for (int i = 0; i < count; ++i) {
    const float *const enters = value(i + kSpread + 1), *const leaves = value(i - kSpread);
    for (std::size_t l = 0; l < kLines; ++l) {
      sums[std::size_t(i) * kLines + l] = sum[l];
      sum[l] += double(enters[l]) - leaves[l];
    }
  }
  for (int i = 0; i < count; ++i) {
    for (std::size_t l = 0; l < kLines; ++l) {
      value(i)[l] = float(sums[std::size_t(i) * kLines + l] / (2 * kSpread + 1));
    }
  }
}

void Spread(const PlaneShape& shape, float* plane) {
  // A row ends with room for whole groups of columns.
  constexpr int kColumns = 16;
  for (int pass = 0; pass < 2; ++pass) {
    tbb::parallel_for(0, shape.height,
                      [&](int y) { MeanOfLines<1>(plane + shape.at(0, y), shape.width, 1); });
    tbb::parallel_for(0, (shape.width + kColumns - 1) / kColumns, [&](int group) {
      MeanOfLines<kColumns>(plane + shape.at(group * kColumns, 0), shape.height, shape.pitch());
    });
  }
}

// How much of an excess pixels take: each, and all that an excess is spread over.
struct SharePlanes {
  float *own, *around;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.own), f(self.around);
  }
};

// Returns the share of a pixel: what it reflects.
float ShareOf(const DenoiserPlanes& planes, const DenoiserInput& input, int x, int y) {
  const std::size_t at = planes.shape.at(x, y);
  const std::size_t pixel = std::size_t(y) * std::size_t(input.image.width) + std::size_t(x);
  const float texture = planes.texture->r[at] + planes.texture->g[at] + planes.texture->b[at];
  return std::max(input.coverage[pixel] * texture / input.brightness, kLeastShare);
}

// A half pixel that is one, and what it is to have instead.
struct Outlier {
  int x, y, half;
  float left;   // of its radiance
  float noise;  // that of its surroundings
};

// Returns the outliers of a row.
std::vector<Outlier> FindOutliers(const DenoiserPlanes& planes, int y) {
  std::vector<Outlier> found;
  for (int x = 0; x < planes.shape.width; ++x) {
    const std::size_t at = planes.shape.at(x, y);
    for (int h = 0; h < 2; ++h) {
      const HalfPlanes &half = planes.halves[h], &other = planes.halves[1 - h];
      const float brightness = Brightness(half, at);
      // Few are that much brighter than the same pixel of the other half.
      if (brightness <= kTimesBrighter * Brightness(other, at)) continue;
      const Surroundings others = Around(planes.shape, other, x, y);
      if (!IsOutlier(brightness, others)) continue;
      found.push_back({x, y, h, others.brightness / brightness, others.noise});
    }
  }
  return found;
}

}  // namespace

OutlierExcess TakeOutliers(const DenoiserInput& input, DenoiserPlanes& planes) {
  const PlaneShape& shape = planes.shape;
  // All are found before any is taken.
  std::vector<std::vector<Outlier>> rows(std::size_t(shape.height));
  tbb::parallel_for(0, shape.height, [&](int y) { rows[y] = FindOutliers(planes, y); });
  OutlierExcess result;
  for (const std::vector<Outlier>& row : rows) result.outliers += row.size();
  if (result.outliers == 0) return result;

  soa::Table<TexturePlanes> excess(std::uint32_t(shape.size()));
  for (const std::vector<Outlier>& row : rows) {
    for (const Outlier& outlier : row) {
      const std::size_t at = shape.at(outlier.x, outlier.y);
      const HalfPlanes& half = planes.halves[outlier.half];
      const float second = planes.second[at];
      const float taken = (1 - outlier.left) * (outlier.half == 0 ? 1 - second : second);
      excess->r[at] += taken * half.r[at] * planes.texture->r[at];
      excess->g[at] += taken * half.g[at] * planes.texture->g[at];
      excess->b[at] += taken * half.b[at] * planes.texture->b[at];
      half.r[at] *= outlier.left, half.g[at] *= outlier.left, half.b[at] *= outlier.left;
      half.noise[at] = outlier.noise;
    }
  }
  for (const soa::Table<HalfPlanes>& half : planes.halves) RepeatEdges(shape, half);
  // Pixel i gives to pixel j in proportion to the share of j. The mean is symmetric, so what i
  // gives adds up to its excess.
  soa::Table<SharePlanes> shares(std::uint32_t(shape.size()));
  const auto for_each_pixel = [&](const auto& f) {
    tbb::parallel_for(0, shape.height, [&](int y) {
      for (int x = 0; x < shape.width; ++x) f(x, y, shape.at(x, y));
    });
  };
  for_each_pixel([&](int x, int y, std::size_t at) {
    shares->own[at] = shares->around[at] = ShareOf(planes, input, x, y);
  });
  Spread(shape, shares->around);
  for_each_pixel([&](int, int, std::size_t at) {
    const float scale = 1 / shares->around[at];
    excess->r[at] *= scale, excess->g[at] *= scale, excess->b[at] *= scale;
  });
  for (float* plane : {excess->r, excess->g, excess->b}) Spread(shape, plane);
  for_each_pixel([&](int, int, std::size_t at) {
    const float share = shares->own[at];
    excess->r[at] *= share, excess->g[at] *= share, excess->b[at] *= share;
  });
  result.spread = std::move(excess);
  return result;
}

}  // namespace skywave
