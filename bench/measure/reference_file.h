// Keeps a reference for later measurements: an EXR whose header records its noise.
#pragma once

#include <cstdint>
#include <string>

#include "bench/measure/error_split.h"

namespace skywave {

struct ReferenceFile {
  Reference reference;
  std::uint32_t samples_per_pixel = 0;  // 0: unknown
  std::string scene_hash;               // empty: unknown
};

// Writes a reference. Its noise is stored as a mean, not per pixel, so half_difference is empty
// after reading. `provenance` is written to the header too.
void WriteReference(const std::string& path, const ReferenceFile& file, Metadata provenance);

// Reads any picture that ReadImage accepts; its noise is unknown unless WriteReference wrote it.
// Throws InputError unless it has the given size and all its pixels are finite.
ReferenceFile ReadReference(const std::string& path, int width, int height,
                            const ReadLimits& limits);

}  // namespace skywave
