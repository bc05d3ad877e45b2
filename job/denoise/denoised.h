// A picture that is clean, as all denoisers return it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace skywave {

struct Denoised {
  Image image;
  // Layer "error", R, G and B: the root of the expected squared error of the image. It is
  // estimated, and 1.96 times as much on both sides makes an interval of about 95 %. kQuick has
  // none.
  std::vector<NamedChannel> error;
  // The channels of groups of lights, which add up to the image; see CleanGroups.
  std::vector<NamedChannel> groups;
  std::uint64_t outliers = 0;  // half pixels that were too bright
  double spread_share = 0;     // of the picture's energy, which was spread around them
  std::string oidn;            // the version of Open Image Denoise that took part; empty: none
  // Of kBest: the shares of the pixels by statistics, by Open Image Denoise, and left noisy.
  double shares[3] = {};
};

}  // namespace skywave
