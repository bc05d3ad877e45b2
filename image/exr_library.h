// Decodes the rarer kinds of OpenEXR files by the OpenEXR library.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "image/exr_header.h"
#include "image/image.h"

namespace skywave {

// What is read of a part: the channels of red, green and blue, or one for all of them, and others.
struct ExrRequest {
  std::vector<std::string> names;
  std::vector<std::string> layers;
  // The channels are RY, Y and BY, of which two have fewer samples: colours are wanted instead.
  bool interpolate_chroma = false;
};

// Decodes the part that `header` is of. Files in whose decoding the library has known holes are
// decoded in a process of its own that can do nothing else, unless `limits.trust_input` says
// otherwise. Throws InputError(path).
LayeredImage DecodeByLibrary(const std::string& path, std::string_view bytes,
                             const ReadLimits& limits, const ExrHeader& header,
                             const ExrRequest& request);

}  // namespace skywave
