#include "job/denoise/denoise.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "job/denoise/outliers.h"
#include "job/denoise/planes.h"
#include "kernels/cross_filter.h"

namespace skywave {
namespace {

// The border of the features never matches the picture.
constexpr float kNoCoverage = 1e4f;

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

template <class Planes>
void RepeatEdges(const PlaneShape& shape, const soa::Table<Planes>& planes) {
  std::vector<float*> columns;
  Planes::ForEachColumn(planes.columns(), [&](float* column) { columns.push_back(column); });
  tbb::parallel_for(std::size_t(0), columns.size(),
                    [&](std::size_t i) { RepeatEdge(shape, columns[i]); });
}

DenoiserPlanes ReadPlanes(const DenoiserInput& input) {
  const PlaneShape shape = {input.image.width, input.image.height};
  DenoiserPlanes planes(shape);
  tbb::parallel_for(0, shape.height, [&](int y) { ReadRow(input, y, planes); });
  FillRim(shape, kNoCoverage, planes.features->coverage);
  tbb::parallel_for(0, shape.height, [&](int y) { FindSlopes(shape, y, planes.features); });
  for (const soa::Table<HalfPlanes>& half : planes.halves) RepeatEdges(shape, half);
  return planes;
}

// Replaces the noise of both halves by what SmoothNoise makes of it.
void SmoothNoises(const PlaneShape& shape, soa::Table<HalfPlanes> (&halves)[2]) {
  for (soa::Table<HalfPlanes>& half : halves) {
    std::vector<float> smooth(shape.size());
    tbb::parallel_for(0, shape.height, [&](int y) { SmoothNoise(shape, half, y, smooth.data()); });
    std::copy(smooth.begin(), smooth.end(), half->noise);
    RepeatEdge(shape, half->noise);
  }
}

}  // namespace

Denoised Denoise(const std::string& name, const Image& image,
                 std::span<const NamedChannel> layers) {
  const DenoiserInput input = FindInput(name, image, layers);
  DenoiserPlanes planes = ReadPlanes(input);
  const PlaneShape& shape = planes.shape;
  const OutlierExcess outliers = TakeOutliers(input, planes);
  if (outliers.outliers != 0) {
    for (const soa::Table<HalfPlanes>& half : planes.halves) RepeatEdges(shape, half);
  }
  SmoothNoises(shape, planes.halves);

  const std::uint32_t size = std::uint32_t(shape.size());
  soa::Table<HalfPlanes> filtered[2], next[2];
  for (int h = 0; h < 2; ++h) {
    filtered[h] = soa::Table<HalfPlanes>(size, soa::Touch::kLater);
    next[h] = soa::Table<HalfPlanes>(size, soa::Touch::kLater);
  }
  const HalfPlanes noisy[2] = {planes.halves[0], planes.halves[1]};
  for (const FilterLevel& level : kFilterLevels) {
    const bool first = &level == kFilterLevels;
    const HalfPlanes in[2] = {first ? noisy[0] : filtered[0].columns(),
                              first ? noisy[1] : filtered[1].columns()};
    const HalfPlanes out[2] = {next[0], next[1]};
    ForEachTile(shape, [&](const FilterTile& tile) {
      CrossFilter(shape, planes.features, in, level, tile, out);
    });
    for (int h = 0; h < 2; ++h) {
      std::swap(filtered[h], next[h]);
      RepeatEdges(shape, filtered[h]);
    }
  }
  const HalfPlanes clean[2] = {filtered[0], filtered[1]};
  const soa::Table<ErrorPlanes> squared_error(size, soa::Touch::kLater);
  ForEachTile(shape, [&](const FilterTile& tile) {
    EstimateError(shape, noisy, clean, tile, squared_error);
  });

  Denoised result = {.image = Image(shape.width, shape.height),
                     .error = {{"error.R", {}}, {"error.G", {}}, {"error.B", {}}},
                     .outliers = outliers.outliers};
  for (NamedChannel& channel : result.error) channel.values.resize(input.samples.size());
  const float* const halves[3][2] = {
      {clean[0].r, clean[1].r}, {clean[0].g, clean[1].g}, {clean[0].b, clean[1].b}};
  const float* const textures[3] = {planes.texture->r, planes.texture->g, planes.texture->b};
  const float* const errors[3] = {squared_error->r, squared_error->g, squared_error->b};
  const float* const spread[3] = {outliers.spread->r, outliers.spread->g, outliers.spread->b};
  tbb::parallel_for(0, shape.height, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      const std::size_t at = shape.at(x, y);
      const std::size_t pixel = std::size_t(y) * std::size_t(shape.width) + std::size_t(x);
      const float second = input.half_samples[pixel] / input.samples[pixel];
      for (std::size_t c = 0; c < 3; ++c) {
        const float light = (1 - second) * halves[c][0][at] + second * halves[c][1][at];
        // Where light was spread, the picture is not known to be right.
        const float more = spread[c] != nullptr ? spread[c][at] : 0;
        result.image.rgb[3 * pixel + c] = light * textures[c][at] + more;
        const float error2 = errors[c][at] * textures[c][at] * textures[c][at] + more * more;
        result.error[c].values[pixel] = std::sqrt(error2);
      }
    }
  });
  double spread_sum = 0, sum = 0;
  for (int y = 0; y < shape.height && result.outliers != 0; ++y) {
    for (int x = 0; x < shape.width; ++x) {
      const std::size_t pixel = std::size_t(y) * std::size_t(shape.width) + std::size_t(x);
      for (std::size_t c = 0; c < 3; ++c) {
        spread_sum += spread[c][shape.at(x, y)];
        sum += image.rgb[3 * pixel + c];
      }
    }
  }
  if (sum > 0) result.spread_share = spread_sum / sum;
  return result;
}

std::string OutlierNote(const Denoised& denoised) {
  if (denoised.outliers == 0) return "";
  return fmt::format(
      "the denoiser spread {:.2g} % of the picture's light, the excess of {} outlier{}",
      100 * denoised.spread_share, denoised.outliers, denoised.outliers == 1 ? "" : "s");
}

}  // namespace skywave
