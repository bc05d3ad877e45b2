#include "wavefront/adaptive.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "kernels/camera.h"
#include "wavefront/film/film_area.h"

namespace skywave {
namespace {

constexpr int kReachX = 1, kReachY = 2;  // of what is nearby [blocks]
constexpr double kDarkest = 0.1;         // of the mean of the picture

// The blocks of a film, row by row.
struct BlockGrid {
  int across, down;
  std::size_t count() const { return std::size_t(across) * std::size_t(down); }
  std::size_t index(int x, int y) const {
    return std::size_t(y) * std::size_t(across) + std::size_t(x);
  }
};

void Add(NoiseSums& sum, const NoiseSums& more) {
  sum.variance += more.variance;
  sum.mean += more.mean;
  sum.values += more.values;
}

// Returns the sums of the blocks nearby that have the other colour.
NoiseSums SumNearby(const BlockGrid& grid, const std::vector<NoiseSums>& blocks, int x, int y) {
  NoiseSums sum;
  for (int j = std::max(y - kReachY, 0); j <= std::min(y + kReachY, grid.down - 1); ++j) {
    for (int i = std::max(x - kReachX, 0); i <= std::min(x + kReachX, grid.across - 1); ++i) {
      if ((i + j + x + y) % 2 != 0) Add(sum, blocks[grid.index(i, j)]);
    }
  }
  return sum;
}

}  // namespace

std::vector<double> WantedSamples(const Film& film, const SampleCounts& samples, double error) {
  const FilmArea& area = film.layout().area;
  constexpr int kWidth = int(kBeamWidth), kHeight = int(kBeamHeight);
  const BlockGrid grid = {area.width / kWidth, area.height / kHeight};
  std::vector<NoiseSums> blocks(grid.count());
  NoiseSums of_color[2];
  for (int y = 0; y < grid.down; ++y) {
    for (int x = 0; x < grid.across; ++x) {
      NoiseSums& block = blocks[grid.index(x, y)];
      block = film.SumNoise({x * kWidth, y * kHeight, kWidth, kHeight}, samples);
      Add(of_color[(x + y) % 2], block);
    }
  }
  // At first this holds the root of the relative variance of a sample.
  std::vector<double> wanted(grid.count(), std::numeric_limits<double>::infinity());
  double sum[2] = {}, values[2] = {};
  for (int y = 0; y < grid.down; ++y) {
    for (int x = 0; x < grid.across; ++x) {
      const int color = (x + y) % 2;
      const NoiseSums nearby = SumNearby(grid, blocks, x, y), &others = of_color[1 - color];
      if (nearby.values == 0) continue;
      const double mean = nearby.mean / nearby.values;
      const double darkest = kDarkest * others.mean / others.values;
      const double scale = mean * mean + darkest * darkest;
      const std::size_t i = grid.index(x, y);
      wanted[i] = scale > 0 ? std::sqrt(nearby.variance / nearby.values / scale) : 0;
      sum[color] += wanted[i] * blocks[i].values;
      values[color] += blocks[i].values;
    }
  }
  for (int y = 0; y < grid.down; ++y) {
    for (int x = 0; x < grid.across; ++x) {
      const int color = (x + y) % 2;
      if (values[color] > 0) wanted[grid.index(x, y)] *= sum[color] / values[color] / error / error;
    }
  }
  return wanted;
}

}  // namespace skywave
