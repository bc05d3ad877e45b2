#include "job/denoise/statistics.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
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

namespace {

HalfTables NewHalves(const PlaneShape& shape) { return {NewHalf(shape), NewHalf(shape)}; }

}  // namespace

HalfTables FilterHalves(const DenoiserPlanes& planes) {
  const PlaneShape& shape = planes.shape;
  const HalfPlanes noisy[2] = {planes.halves[0], planes.halves[1]};
  HalfPlanes in[2] = {noisy[0], noisy[1]};
  HalfTables filtered = NewHalves(shape), next = NewHalves(shape);
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

std::vector<HalfTables> FilterGuides(const DenoiserPlanes& planes) {
  std::vector<HalfTables> guides;
  HalfPlanes in[2] = {planes.halves[0], planes.halves[1]};
  for (std::size_t i = 0; i + 1 < std::size(kFilterLevels); ++i) {
    const HalfTables& out = guides.emplace_back(NewHalves(planes.shape));
    ForEachTile(planes.shape, [&](const FilterTile& tile) {
      CrossFilter(planes.shape, planes.features, in, kFilterLevels[i], tile, {out[0], out[1]});
    });
    for (int h = 0; h < 2; ++h) RepeatEdges(planes.shape, out[h]), in[h] = out[h];
  }
  return guides;
}

void FilterByGuides(const DenoiserPlanes& planes, const std::vector<HalfTables>& guides,
                    const soa::Table<HalfPlanes>& part) {
  const PlaneShape& shape = planes.shape;
  const HalfTables by = NewHalves(shape);  // the weights of each half
  const soa::Table<HalfPlanes> unused = NewHalf(shape);
  for (std::size_t i = 0; i < std::size(kFilterLevels); ++i) {
    const HalfTables& guide = i == 0 ? planes.halves : guides[i - 1];
    ForEachTile(shape, [&](const FilterTile& tile) {
      // What is in the place of one half is averaged by the weights of the other one.
      const FilterLevel& level = kFilterLevels[i];
      CrossFilter(shape, planes.features, {part, guide[1]}, level, tile, {by[1], unused});
      CrossFilter(shape, planes.features, {guide[0], part}, level, tile, {unused, by[0]});
    });
    ForEachPixel(shape, [&](std::size_t, std::size_t at) {
      part->r[at] = 0.5f * (by[0]->r[at] + by[1]->r[at]);
      part->g[at] = 0.5f * (by[0]->g[at] + by[1]->g[at]);
      part->b[at] = 0.5f * (by[0]->b[at] + by[1]->b[at]);
    });
    RepeatEdges(shape, part);
  }
}

}  // namespace skywave
