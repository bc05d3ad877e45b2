#include "job/denoise/candidate.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace skywave {

void AverageAround(const PlaneShape& shape, int around, std::vector<float>& plane) {
  std::vector<float> rows(shape.size());
  const float scale = 1 / float((2 * around + 1) * (2 * around + 1));
  tbb::parallel_for(-around, shape.height + around, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      float sum = 0;
      for (int dx = -around; dx <= around; ++dx) sum += plane[shape.at(x + dx, y)];
      rows[shape.at(x, y)] = sum;
    }
  });
  tbb::parallel_for(0, shape.height, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      float sum = 0;
      for (int dy = -around; dy <= around; ++dy) sum += rows[shape.at(x, y + dy)];
      plane[shape.at(x, y)] = scale * sum;
    }
  });
}

soa::Table<HalfPlanes> NewHalf(const PlaneShape& shape) {
  return soa::Table<HalfPlanes>(std::uint32_t(shape.size()), soa::Touch::kLater);
}

Candidate MeanOfHalves(const DenoiserPlanes& planes, const HalfPlanes (&halves)[2]) {
  Candidate mean(std::uint32_t(planes.shape.size()));
  const float* const values[3][2] = {
      {halves[0].r, halves[1].r}, {halves[0].g, halves[1].g}, {halves[0].b, halves[1].b}};
  float* const light[3] = {mean.light->r, mean.light->g, mean.light->b};
  ForEachPixel(planes.shape, [&](std::size_t, std::size_t at) {
    const float second = planes.second[at];
    for (std::size_t c = 0; c < 3; ++c) {
      light[c][at] = (1 - second) * values[c][0][at] + second * values[c][1][at];
    }
  });
  return mean;
}

Candidate WithError(const DenoiserPlanes& planes, const HalfPlanes (&halves)[2]) {
  Candidate mean = MeanOfHalves(planes, halves);
  const HalfPlanes noisy[2] = {planes.halves[0], planes.halves[1]};
  ForEachTile(planes.shape, [&](const FilterTile& tile) {
    EstimateError(planes.shape, noisy, halves, tile, mean.squared_error);
  });
  return mean;
}

void EstimateWide(const DenoiserPlanes& planes, const HalfTables& clean,
                  const ErrorPlanes& squared_error) {
  constexpr int kVarianceAround = 3, kBiasAround = 8;  // pixels on each side
  const PlaneShape& shape = planes.shape;
  const auto colors = [](const HalfPlanes& half) { return std::array{half.r, half.g, half.b}; };
  const auto f0 = colors(clean[0]), f1 = colors(clean[1]);
  const auto x0 = colors(planes.halves[0]), x1 = colors(planes.halves[1]);
  float* const out[3] = {squared_error.r, squared_error.g, squared_error.b};
  std::vector<float> variance(shape.size()), bias(shape.size());
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t at = 0; at < shape.size(); ++at) {
      const float apart = f0[c][at] - f1[c][at];
      variance[at] = 0.25f * apart * apart;
      bias[at] = (f0[c][at] - x0[c][at]) * (f1[c][at] - x1[c][at]);
    }
    AverageAround(shape, kVarianceAround, variance);
    AverageAround(shape, kBiasAround, bias);
    ForEachPixel(shape, [&](std::size_t, std::size_t at) {
      out[c][at] = variance[at] + std::max(bias[at], 0.0f);
    });
  }
}

Denoised PictureOf(const DenoiserPlanes& planes, const OutlierExcess& outliers,
                   const Candidate& clean, bool with_error) {
  const PlaneShape& shape = planes.shape;
  Denoised result = {.image = Image(shape.width, shape.height),
                     .error = {},
                     .groups = {},
                     .outliers = outliers.outliers,
                     .oidn = ""};
  if (with_error) result.error = {{"error.R", {}}, {"error.G", {}}, {"error.B", {}}};
  for (NamedChannel& channel : result.error) channel.values.resize(result.image.rgb.size() / 3);
  const float* const lights[3] = {clean.light->r, clean.light->g, clean.light->b};
  const float* const textures[3] = {planes.texture->r, planes.texture->g, planes.texture->b};
  const float* const errors[3] = {clean.squared_error->r, clean.squared_error->g,
                                  clean.squared_error->b};
  const float* const spread[3] = {outliers.spread->r, outliers.spread->g, outliers.spread->b};
  ForEachPixel(shape, [&](std::size_t pixel, std::size_t at) {
    for (std::size_t c = 0; c < 3; ++c) {
      // Where light was spread, the picture is not known to be right.
      const float more = spread[c] != nullptr ? spread[c][at] : 0;
      result.image.rgb[3 * pixel + c] = lights[c][at] * textures[c][at] + more;
      if (!with_error) continue;
      const float error2 = errors[c][at] * textures[c][at] * textures[c][at] + more * more;
      result.error[c].values[pixel] = std::sqrt(error2);
    }
  });
  if (result.outliers == 0) return result;
  double spread_sum = 0, sum = 0;
  for (int y = 0; y < shape.height; ++y) {
    for (int x = 0; x < shape.width; ++x) {
      const std::size_t pixel = std::size_t(y) * std::size_t(shape.width) + std::size_t(x);
      for (std::size_t c = 0; c < 3; ++c) {
        spread_sum += double(spread[c][shape.at(x, y)]);
        sum += std::abs(double(result.image.rgb[3 * pixel + c]));
      }
    }
  }
  if (sum > 0) result.spread_share = spread_sum / sum;
  return result;
}

}  // namespace skywave
