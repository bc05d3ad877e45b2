// The light of a picture with catchers has parts, of which its layers are made: by the film, where
// they are means of samples, and by a denoiser, which cleans each part by itself.
#pragma once

#include <algorithm>
#include <cstddef>

namespace skywave {

enum class LightPart {
  kObjects,  // what is seen of objects
  kClean,    // what catchers show without the objects
  kChange,   // what objects add to that, or take away
  kBackdrop  // what camera rays would see if nothing was in front
};
inline constexpr std::size_t kLightParts = 4;
inline constexpr std::size_t kPartsOfCatchers = 3;  // the first ones

// The light of catchers in a pixel, by channel.
struct CaughtLight {
  double clean[3], change[3];
};

// Returns the ratio of the light with objects to that without; 1 where there is none.
inline double ShadowOf(const CaughtLight& light, std::size_t channel) {
  const double clean = light.clean[channel];
  return clean > 0 ? (clean + light.change[channel]) / clean : 1;
}

// Returns the share of the light of catchers that objects leave to all of its channels: the least
// of their ratios. What is beyond it is light that objects add.
inline double KeptShare(const CaughtLight& light) {
  double kept = 1;
  for (std::size_t c = 0; c < 3; ++c) kept = std::min(kept, std::max(ShadowOf(light, c), 0.0));
  return kept;
}

// Returns the light that objects add to what they keep. It is less than nothing by rounding alone
// where the light has no signs.
inline double AddedLight(const CaughtLight& light, double kept, std::size_t channel) {
  return light.change[channel] + (1 - kept) * light.clean[channel];
}

}  // namespace skywave
