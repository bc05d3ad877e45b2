#include "job/denoise/planes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace skywave {
namespace {

// Units of the features: the difference by which pixels become strangers.
constexpr float kNormalUnit = 0.1f;  // of unit vectors
constexpr float kAlbedoUnit = 0.1f;  // of reflectance
// Black surfaces can be lit as well: light is not divided by less than this.
constexpr float kDarkest = 0.02f;

}  // namespace

DenoiserPlanes::DenoiserPlanes(const PlaneShape& given)
    : shape(given),
      second(shape.size()),
      texture(std::uint32_t(shape.size()), soa::Touch::kLater),
      halves{soa::Table<HalfPlanes>(std::uint32_t(shape.size()), soa::Touch::kLater),
             soa::Table<HalfPlanes>(std::uint32_t(shape.size()), soa::Touch::kLater)},
      features(std::uint32_t(shape.size())) {}

void ReadRow(const DenoiserInput& input, int y, DenoiserPlanes& planes) {
  const FeaturePlanes& f = planes.features;
  float* const textures[3] = {planes.texture->r, planes.texture->g, planes.texture->b};
  float* const normals[3] = {f.normal_x, f.normal_y, f.normal_z};
  float* const albedos[3] = {f.albedo_r, f.albedo_g, f.albedo_b};
  float* colors[2][3];
  for (int h = 0; h < 2; ++h) {
    const HalfPlanes& half = planes.halves[h];
    colors[h][0] = half.r, colors[h][1] = half.g, colors[h][2] = half.b;
  }
  for (int x = 0; x < input.image.width; ++x) {
    const std::size_t pixel = std::size_t(y) * std::size_t(input.image.width) + std::size_t(x);
    const std::size_t at = planes.shape.at(x, y);
    const float coverage = input.coverage[pixel];
    planes.second[at] = input.half_samples[pixel] / input.samples[pixel];
    const float n = input.samples[pixel], n1 = input.half_samples[pixel], n0 = n - n1;
    float noise0 = 0, noise1 = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float albedo = input.albedo[c][pixel];
      // Colours are in units of the picture's own, as the scale of a map is arbitrary.
      const float texture = input.brightness * (coverage * (albedo + kDarkest) + (1 - coverage));
      const float all = input.image.rgb[3 * pixel + c], second = input.half[c][pixel];
      const float first = (n * all - n1 * second) / n0;
      // The squares around the mean of all samples are those around the means of the halves and
      // those of the means.
      const float apart = first - second, variance1 = std::max(input.half_variance[c][pixel], 0.0f);
      const float squares =
          (n - 1) * input.variance[c][pixel] - (n1 - 1) * variance1 - n0 * n1 / n * apart * apart;
      const float variance0 = std::max(squares, 0.0f) / (n0 - 1);
      const float scale = 1 / texture;
      textures[c][at] = texture;
      colors[0][c][at] = first * scale;
      colors[1][c][at] = second * scale;
      noise0 += variance0 * scale * scale / n0;
      noise1 += variance1 * scale * scale / n1;
      normals[c][at] = input.normal[c][pixel] * (1 / kNormalUnit);
      albedos[c][at] = albedo * (1 / kAlbedoUnit);
    }
    planes.halves[0]->noise[at] = noise0;
    planes.halves[1]->noise[at] = noise1;
    f.depth[at] = std::max(input.depth[pixel], 1e-30f);
    f.coverage[at] = coverage * (1 / kCoverageUnit);
  }
  TakeLogarithms(planes.shape, y, 1 / kDepthUnit, f.depth);
}

void FindSlopes(const PlaneShape& shape, int y, const FeaturePlanes& features) {
  const auto slope = [&](std::size_t here, std::size_t before, std::size_t after) {
    const auto is_surface = [&](std::size_t at) {
      return features.coverage[at] > 0.5f / kCoverageUnit &&
             features.coverage[at] < 1.5f / kCoverageUnit;
    };
    if (!is_surface(here)) return 0.0f;
    const float depth = features.depth[here];
    const float forward = features.depth[after] - depth, backward = depth - features.depth[before];
    if (!is_surface(before)) return is_surface(after) ? forward : 0;
    if (!is_surface(after)) return backward;
    // The smaller one does not leave the surface.
    return std::abs(forward) < std::abs(backward) ? forward : backward;
  };
  for (int x = 0; x < shape.width; ++x) {
    const std::size_t at = shape.at(x, y);
    features.depth_dx[at] = slope(at, at - 1, at + 1);
    features.depth_dy[at] = slope(at, at - shape.pitch(), at + shape.pitch());
  }
}

void RepeatEdge(const PlaneShape& shape, float* plane) {
  const int end = int(shape.pitch()) - PlaneShape::kRim;  // of a row, with its padding
  for (int y = 0; y < shape.height; ++y) {
    float* const row = plane + shape.at(0, y);
    std::fill(row - PlaneShape::kRim, row, row[0]);
    std::fill(row + shape.width, row + end, row[shape.width - 1]);
  }
  const auto copy = [&](int from, int to) {
    std::copy_n(plane + shape.at(-PlaneShape::kRim, from), shape.pitch(),
                plane + shape.at(-PlaneShape::kRim, to));
  };
  for (int y = 1; y <= PlaneShape::kRim; ++y)
    copy(0, -y), copy(shape.height - 1, shape.height - 1 + y);
}

void FillRim(const PlaneShape& shape, float value, float* plane) {
  const int end = int(shape.pitch()) - PlaneShape::kRim;
  for (int y = -PlaneShape::kRim; y < shape.height + PlaneShape::kRim; ++y) {
    float* const row = plane + shape.at(0, y);
    const bool inside = y >= 0 && y < shape.height;
    std::fill(row - PlaneShape::kRim, inside ? row : row + end, value);
    if (inside) std::fill(row + shape.width, row + end, value);
  }
}

DenoiserPlanes ReadPlanes(const DenoiserInput& input) {
  const PlaneShape shape = {input.image.width, input.image.height};
  DenoiserPlanes planes(shape);
  planes.brightness = input.brightness;
  tbb::parallel_for(0, shape.height, [&](int y) { ReadRow(input, y, planes); });
  FillRim(shape, kNoCoverage, planes.features->coverage);
  tbb::parallel_for(0, shape.height, [&](int y) { FindSlopes(shape, y, planes.features); });
  for (const soa::Table<HalfPlanes>& half : planes.halves) RepeatEdges(shape, half);
  RepeatEdges(shape, planes.texture);
  return planes;
}

}  // namespace skywave
