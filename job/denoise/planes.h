// The planes that the denoiser works on, and how a picture becomes planes.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "job/denoise/input.h"
#include "kernels/cross_filter.h"
#include "wavefront/soa.h"

namespace skywave {

using HalfTables = std::array<soa::Table<HalfPlanes>, 2>;

struct DenoiserPlanes {
  explicit DenoiserPlanes(const PlaneShape& shape);

  PlaneShape shape;
  float brightness = 1;       // the unit of light
  std::vector<float> second;  // share of the samples that are in second halves, by place
  soa::Table<TexturePlanes> texture;
  HalfTables halves;
  soa::Table<FeaturePlanes> features;
};

// Returns the planes of a picture.
DenoiserPlanes ReadPlanes(const DenoiserInput& input);

// Writes row `y` of the planes of the picture, without rims.
void ReadRow(const DenoiserInput& input, int y, DenoiserPlanes& planes);
// Writes the slopes of the depth in row `y`, when all rows have been read.
void FindSlopes(const PlaneShape& shape, int y, const FeaturePlanes& features);

// Writes the rim of a plane: the nearest pixel of the picture, or one value.
void RepeatEdge(const PlaneShape& shape, float* plane);
void FillRim(const PlaneShape& shape, float value, float* plane);

// Returns all planes of a table.
template <class Planes>
std::vector<float*> ColumnsOf(const Planes& planes) {
  std::vector<float*> columns;
  Planes::ForEachColumn(planes, [&](float* column) { columns.push_back(column); });
  return columns;
}

// Repeats the edges of all planes of a table.
template <class Planes>
void RepeatEdges(const PlaneShape& shape, const soa::Table<Planes>& planes) {
  const std::vector<float*> columns = ColumnsOf(planes.columns());
  tbb::parallel_for(std::size_t(0), columns.size(),
                    [&](std::size_t i) { RepeatEdge(shape, columns[i]); });
}

// Calls f(tile) for the tiles of a picture, on all threads.
template <class F>
void ForEachTile(const PlaneShape& shape, const F& f) {
  const int columns = (shape.width + FilterTile::kWidth - 1) / FilterTile::kWidth;
  const int rows = (shape.height + FilterTile::kHeight - 1) / FilterTile::kHeight;
  tbb::parallel_for(0, columns * rows, [&](int i) {
    const int x = i % columns * FilterTile::kWidth, y = i / columns * FilterTile::kHeight;
    f(FilterTile{.x = x,
                 .y = y,
                 .width = std::min(FilterTile::kWidth, shape.width - x),
                 .height = std::min(FilterTile::kHeight, shape.height - y)});
  });
}

// Calls f(pixel, at) with the number of each pixel and its place on the planes.
template <class F>
void ForEachPixel(const PlaneShape& shape, const F& f) {
  tbb::parallel_for(0, shape.height, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      f(std::size_t(y) * std::size_t(shape.width) + std::size_t(x), shape.at(x, y));
    }
  });
}

}  // namespace skywave
