#include "job/denoise/input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/error.h"

namespace skywave {
namespace {

// A power of two scales without rounding, so a part of a picture has the bits of the whole.
float BrightnessOf(const Image& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += std::abs(value);
  const double mean = sum / double(image.rgb.size());
  int exponent = 0;
  std::frexp(std::max(mean, 1e-30), &exponent);
  return std::ldexp(1.0f, exponent);
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

InputError MissingLayer(const std::string& name, std::string_view channel) {
  return {InputPosition::File(name),
          fmt::format("has no channel {}, which the denoiser needs; render with `denoise`, or with "
                      "the layers {} in `aovs`",
                      channel, ToString(DenoiserLayers({})))};
}

std::span<const float> FindChannel(const std::string& name, std::size_t pixels,
                                   std::span<const NamedChannel> layers, std::string_view channel) {
  const auto found = std::find_if(layers.begin(), layers.end(),
                                  [&](const NamedChannel& layer) { return layer.name == channel; });
  if (found == layers.end()) {
    throw MissingLayer(name, channel);
  }
  if (found->values.size() != pixels) {
    throw InputError(InputPosition::File(name), fmt::format("has {} pixels, and its channel {} {}",
                                                            pixels, channel, found->values.size()));
  }
  return found->values;
}

AovSet DenoiserLayers(AovSet layers) {
  static const AovSet of_all = ParseAovs("denoiser").value();
  const bool of_catchers = Sums(layers, AovSum::kDifference);
  return of_all | (of_catchers ? CatcherAovs() | PartAovs() : 0);
}

std::vector<std::string> ChannelsOf(AovSet layers) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < Aovs().size(); ++k) {
    if ((layers >> k & 1) == 0) continue;
    for (const char letter : Aovs()[k].channels) {
      names.push_back(fmt::format("{}.{}", Aovs()[k].name, letter));
    }
  }
  return names;
}

bool HasDenoiserLayers(AovSet layers) { return (DenoiserLayers(layers) & ~layers) == 0; }

std::vector<std::string> DenoiserChannels() { return ChannelsOf(DenoiserLayers({})); }

bool CanDenoise(const Image& image, std::span<const NamedChannel> layers) {
  const std::size_t pixels = image.rgb.size() / 3;
  const std::span<const float> samples = FindChannel("", pixels, layers, "samples.V");
  return FindTooFew(samples, FindChannel("", pixels, layers, "half.N")) == pixels;
}

DenoiserInput FindInput(const std::string& name, const Image& image,
                        std::span<const NamedChannel> layers, const NoiseLayers& noise) {
  const auto find = [&](std::string_view channel) {
    const std::span<const float> values = FindChannel(name, image.rgb.size() / 3, layers, channel);
    CheckFinite(name, image, channel, values, 1);
    return values;
  };
  const auto of_noise = [&](const std::string& channel) { return find(noise.prefix + channel); };
  CheckFinite(name, image, "RGB", image.rgb, 3);
  const DenoiserInput input = {
      .image = image,
      .brightness = BrightnessOf(image),
      .samples = find("samples.V"),
      .variance = {of_noise("variance.R"), of_noise("variance.G"), of_noise("variance.B")},
      .half = {of_noise("half.R"), of_noise("half.G"), of_noise("half.B")},
      .half_samples = find("half.N"),
      .half_variance = {of_noise("half-variance.R"), of_noise("half-variance.G"),
                        of_noise("half-variance.B")},
      .albedo = {find("albedo.R"), find("albedo.G"), find("albedo.B")},
      .normal = {find("shading-normal.X"), find("shading-normal.Y"), find("shading-normal.Z")},
      .depth = find("depth.Z"),
      .coverage = find(noise.coverage)};
  CheckSamples(name, input);
  return input;
}

}  // namespace skywave
