// The layers that the denoiser reads: which they are, and their values found and checked.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "wavefront/film/aovs.h"

namespace skywave {

// Returns the layers that the denoiser reads, and the names of their channels.
AovSet DenoiserLayers();
std::vector<std::string> DenoiserChannels();

// Returns the error that a picture lacks a channel.
InputError MissingLayer(const std::string& name, std::string_view channel);

// With fewer samples the variance of a half is too uncertain.
inline constexpr std::uint32_t kFewestDenoiserSamples = 4;

// Returns whether every pixel has enough samples in both halves. The layers are there.
bool CanDenoise(const Image& image, std::span<const NamedChannel> layers);

// The values of the channels that the denoiser reads, one per pixel.
struct DenoiserInput {
  const Image& image;
  float brightness;  // a power of two near the mean magnitude of its values
  std::span<const float> samples;
  std::span<const float> variance[3];
  std::span<const float> half[3], half_samples, half_variance[3];
  std::span<const float> albedo[3], normal[3], depth, coverage;
};

// Finds and checks them; see Denoise for errors.
DenoiserInput FindInput(const std::string& name, const Image& image,
                        std::span<const NamedChannel> layers);

}  // namespace skywave
