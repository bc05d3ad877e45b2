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

// Returns the layers that the denoiser reads of a picture that has `layers`: the parts of the light
// of catchers as well if it has any.
AovSet DenoiserLayers(AovSet layers);
// Returns whether `layers` have all of them.
bool HasDenoiserLayers(AovSet layers);
// Returns the names of the channels of layers.
std::vector<std::string> ChannelsOf(AovSet layers);
// Returns those of the layers that the denoiser reads of every picture.
std::vector<std::string> DenoiserChannels();

// Returns the error that a picture lacks a channel.
InputError MissingLayer(const std::string& name, std::string_view channel);
// Returns the values of a channel. Throws InputError if it is missing or has not so many pixels.
std::span<const float> FindChannel(const std::string& name, std::size_t pixels,
                                   std::span<const NamedChannel> layers, std::string_view channel);

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

// Where the noise of a kind of light is, and where in a pixel the light is seen: that of the whole
// picture, or of a part of it.
struct NoiseLayers {
  std::string prefix = "";  // of the layers variance, half and half-variance
  std::string coverage = "coverage.V";
};

// Finds and checks them; see Denoise for errors.
DenoiserInput FindInput(const std::string& name, const Image& image,
                        std::span<const NamedChannel> layers, const NoiseLayers& noise = {});

}  // namespace skywave
