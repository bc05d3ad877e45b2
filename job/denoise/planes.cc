#include "job/denoise/planes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/error.h"
#include "job/denoise/denoise.h"

namespace skywave {
namespace {

// Units of the features: the difference by which pixels become strangers.
constexpr float kNormalUnit = 0.1f;  // of unit vectors
constexpr float kAlbedoUnit = 0.1f;  // of reflectance
constexpr float kDepthUnit = 0.02f;  // of the distance
// Black surfaces can be lit as well: light is not divided by less than this.
constexpr float kDarkest = 0.02f;

// A power of two scales without rounding, so a part of a picture has the bits of the whole.
float BrightnessOf(const Image& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += std::abs(value);
  const double mean = sum / double(image.rgb.size());
  int exponent = 0;
  std::frexp(std::max(mean, 1e-30), &exponent);
  return std::ldexp(1.0f, exponent);
}

std::span<const float> Find(const std::string& name, const Image& image,
                            std::span<const NamedChannel> layers, std::string_view channel) {
  const auto found = std::find_if(layers.begin(), layers.end(),
                                  [&](const NamedChannel& layer) { return layer.name == channel; });
  if (found == layers.end()) {
    throw InputError(InputPosition::File(name),
                     fmt::format("has no channel {}, which the denoiser needs; render with "
                                 "`denoise`, or with the layers {} in `aovs`",
                                 channel, ToString(DenoiserLayers())));
  }
  const std::size_t pixels = image.rgb.size() / 3;
  if (found->values.size() != pixels) {
    throw InputError(InputPosition::File(name), fmt::format("has {} pixels, and its channel {} {}",
                                                            pixels, channel, found->values.size()));
  }
  return found->values;
}

void CheckFinite(const std::string& name, const Image& image, std::string_view channel,
                 std::span<const float> values, std::size_t step) {
  const auto bad =
      std::find_if(values.begin(), values.end(), [](float value) { return !std::isfinite(value); });
  if (bad == values.end()) return;
  const std::size_t pixel = std::size_t(bad - values.begin()) / step;
  const std::size_t width = std::size_t(image.width);
  throw InputError(InputPosition::File(name),
                   fmt::format("channel {} is {} in pixel ({}, {})", channel, *bad, pixel % width,
                               pixel / width));
}

// Returns the first pixel that has too few samples, in all or in one half, or their number.
std::size_t FindTooFew(std::span<const float> samples, std::span<const float> half) {
  std::size_t i = 0;
  while (i < samples.size() && samples[i] >= kFewestDenoiserSamples && half[i] >= 2 &&
         samples[i] - half[i] >= 2) {
    ++i;
  }
  return i;
}

void CheckSamples(const std::string& name, const DenoiserInput& input) {
  const std::size_t i = FindTooFew(input.samples, input.half_samples);
  if (i == input.samples.size()) return;
  const std::size_t width = std::size_t(input.image.width);
  throw InputError(
      InputPosition::File(name),
      fmt::format("pixel ({}, {}) has {} samples, {} of them in one half; the denoiser needs {} or "
                  "more, from the first sample on",
                  i % width, i / width, input.samples[i], input.half_samples[i],
                  kFewestDenoiserSamples));
}

}  // namespace

std::vector<std::string> DenoiserChannels() {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < Aovs().size(); ++k) {
    if ((DenoiserLayers() >> k & 1) == 0) continue;
    for (const char letter : Aovs()[k].channels) {
      names.push_back(fmt::format("{}.{}", Aovs()[k].name, letter));
    }
  }
  return names;
}

bool CanDenoise(const Image& image, std::span<const NamedChannel> layers) {
  const std::span<const float> samples = Find("", image, layers, "samples.V");
  return FindTooFew(samples, Find("", image, layers, "half.N")) == samples.size();
}

DenoiserInput FindInput(const std::string& name, const Image& image,
                        std::span<const NamedChannel> layers) {
  const auto find = [&](std::string_view channel) {
    const std::span<const float> values = Find(name, image, layers, channel);
    CheckFinite(name, image, channel, values, 1);
    return values;
  };
  CheckFinite(name, image, "RGB", image.rgb, 3);
  const DenoiserInput input = {
      .image = image,
      .brightness = BrightnessOf(image),
      .samples = find("samples.V"),
      .variance = {find("variance.R"), find("variance.G"), find("variance.B")},
      .half = {find("half.R"), find("half.G"), find("half.B")},
      .half_samples = find("half.N"),
      .half_variance = {find("half-variance.R"), find("half-variance.G"), find("half-variance.B")},
      .albedo = {find("albedo.R"), find("albedo.G"), find("albedo.B")},
      .normal = {find("shading-normal.X"), find("shading-normal.Y"), find("shading-normal.Z")},
      .depth = find("depth.Z"),
      .coverage = find("coverage.V")};
  CheckSamples(name, input);
  return input;
}

DenoiserPlanes::DenoiserPlanes(const PlaneShape& given)
    : shape(given),
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

}  // namespace skywave
