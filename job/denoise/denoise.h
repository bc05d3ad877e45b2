// A clean picture from the layers of a noisy one, by the statistics of its samples: no network, no
// training. kernels/cross_filter.h has the filter; here are the planes that it works on.
//
// What is filtered is the light that falls on surfaces: the picture divided by the albedo of what
// the pixel shows, so textures stay as they are. Outliers, single samples that are far too bright,
// are found by comparing the halves of the samples: one half has them, and the other half has
// nothing as bright in the pixels around. Their excess is spread over the surface around them, so
// energy is kept.
//
// All of it is local: a pixel depends on those at most 12 pixels away, and near outliers on those
// at most 84 pixels away. The bytes do not depend on threads, tiles or instruction sets.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "job/denoise/input.h"

namespace skywave {

struct Denoised {
  Image image;
  // Layer "error", R, G and B: the root of the expected squared error of the image. It is
  // estimated, and 1.96 times as much on both sides makes an interval of about 95 %.
  std::vector<NamedChannel> error;
  std::uint64_t outliers = 0;  // half pixels that were too bright
  double spread_share = 0;     // of the picture's energy, which was spread around them
};

// Returns the clean picture. `layers` are channels by the names of DenoiserChannels, in any order,
// and may be others too. Throws InputError about `name` if one is missing or has another size, if
// a value is not finite, or where a pixel has too few samples.
Denoised Denoise(const std::string& name, const Image& image, std::span<const NamedChannel> layers);

// Returns one line that says what was done with outliers, or nothing if there were none.
std::string OutlierNote(const Denoised& denoised);

}  // namespace skywave
