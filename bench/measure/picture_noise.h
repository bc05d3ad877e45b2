// Compares the difference of two rendered pictures with the noise that they report themselves, in
// the layers "variance" and "samples", which hold the variance of one sample and the number of
// samples of each pixel.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "image/image.h"

namespace skywave {

// Returns the names of the channels that NoiseOf needs.
std::vector<std::string> NoiseChannels();

// The noise of a picture, pixel by pixel, rows from the top.
struct PictureNoise {
  std::vector<float> variance;  // of one sample, three channels a pixel
  std::vector<float> samples;   // one number a pixel
};

// Returns the noise in layers that were read by the names of NoiseChannels.
PictureNoise NoiseOf(std::span<const NamedChannel> layers);

// The same for a picture that was denoised, whose layer "error" holds standard deviations. Those of
// neighbours are of the same samples, so half_width below is too small for such a picture.
std::vector<std::string> ErrorChannels();
PictureNoise NoiseOfErrors(std::span<const NamedChannel> layers);

// Intervals and shares are those of independent samples. What is counted are values: each of the
// three channels of each pixel.
struct NoiseComparison {
  // Mean of image - reference in R, G and B, and half the width of its 95 % interval.
  std::array<double, 3> mean_difference = {}, half_width = {};
  // The values that have any variance; the shares and means below are theirs.
  std::size_t values = 0;
  // Share of the values whose difference is outside of the 95 % interval that their variance and
  // number of samples give: 0.05 if noise is all that differs.
  double exceeding = 0;
  // Mean of the squared difference over its variance: 1 if noise is all that differs.
  double mean_squared_z = 0;
  // The values without any variance, and how many of them differ all the same.
  std::size_t exact_values = 0, exact_that_differ = 0;
};

// Compares two pictures of the same size. A picture without noise is taken to be exact; one of them
// has to have some.
NoiseComparison CompareNoise(const Image& image, const std::optional<PictureNoise>& image_noise,
                             const Image& reference,
                             const std::optional<PictureNoise>& reference_noise);

}  // namespace skywave
