// A reference kept for other measurements: an EXR whose header tells how noisy it is.
#pragma once

#include <cstdint>
#include <string>

#include "measure/error_split.h"

namespace skywave {

struct ReferenceFile {
  Reference reference;
  std::uint32_t samples_per_pixel = 0;  // 0: unknown
  std::string scene_hash;               // empty: unknown
};

// Noise is kept as a mean, not pixel by pixel: half_difference is not there when read again.
// `provenance` goes into the header too.
void WriteReference(const std::string& path, const ReferenceFile& file, Metadata provenance);

// Any picture that ReadImage takes; of a picture that WriteReference did not write the noise is
// unknown. Throws InputError unless it has the given size and all its pixels are finite.
ReferenceFile ReadReference(const std::string& path, int width, int height,
                            const ReadLimits& limits);

}  // namespace skywave
