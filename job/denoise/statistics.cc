#include "job/denoise/statistics.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "job/denoise/candidate.h"
#include "kernels/cross_filter.h"
#include "kernels/feature_fit.h"

namespace skywave {

void SmoothNoises(const DenoiserInput& input, DenoiserPlanes& planes) {
  const PlaneShape& shape = planes.shape;
  std::vector<float> samples(shape.size()), smooth(shape.size());
  for (int h = 0; h < 2; ++h) {
    const HalfPlanes &half = planes.halves[h], &other = planes.halves[1 - h];
    ForEachPixel(shape, [&](std::size_t pixel, std::size_t at) {
      const float second = input.half_samples[pixel];
      samples[at] = h == 1 ? second : input.samples[pixel] - second;
    });
    tbb::parallel_for(0, shape.height, [&](int y) {
      SmoothNoise(shape, half, other, samples.data(), y, smooth.data());
    });
    std::copy(smooth.begin(), smooth.end(), half.noise);
    RepeatEdge(shape, half.noise);
  }
}

HalfTables FilterHalves(const DenoiserPlanes& planes) {
  const PlaneShape& shape = planes.shape;
  const HalfPlanes noisy[2] = {planes.halves[0], planes.halves[1]};
  HalfPlanes in[2] = {noisy[0], noisy[1]};
  HalfTables filtered, next;
  for (int h = 0; h < 2; ++h) filtered[h] = NewHalf(shape), next[h] = NewHalf(shape);
  // Calls filter(out), which reads `in`; the next filter reads what this one has written.
  const auto run = [&](const auto& filter) {
    filter({next[0].columns(), next[1].columns()});
    for (int h = 0; h < 2; ++h) {
      std::swap(filtered[h], next[h]);
      RepeatEdges(shape, filtered[h]);
      in[h] = filtered[h];
    }
  };
  using Halves = HalfPlanes[2];
  for (const FilterLevel& level : kFilterLevels) {
    run([&](const Halves& out) {
      ForEachTile(shape, [&](const FilterTile& tile) {
        CrossFilter(shape, planes.features, in, level, tile, out);
      });
    });
  }
  run([&](const Halves& out) {
    tbb::parallel_for(0, shape.height, [&](int y) {
      FitToFeatures(shape, planes.features, planes.texture, planes.brightness, noisy, in, y, out);
    });
  });
  return filtered;
}

}  // namespace skywave
