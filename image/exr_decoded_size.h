// How many bytes a compressed chunk of an EXR file holds.
//
// OpenEXR 3.1.5 does not ask: from a chunk that decodes to less than its pixels need, it hands out
// what the memory held before. For image/ only.
#pragma once

#include <cstdint>
#include <string_view>

#include "image/exr_header.h"

namespace skywave {

// [bytes] that `stored` decodes to, or -1 when it cannot be decoded or holds more than `most`
// bytes. Knows RLE, ZIPS and ZIP; for the others, where the library checks by itself, it is `most`.
std::int64_t DecodedSize(ExrCompression compression, std::string_view stored, std::int64_t most);

}  // namespace skywave
