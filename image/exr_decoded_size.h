// Computes the decoded size of a compressed chunk of an EXR file.
//
// OpenEXR 3.1.5 does not check it: if a chunk decodes to fewer bytes than its pixels need, the rest
// is uninitialised memory. For image/ only.
#pragma once

#include <cstdint>
#include <string_view>

#include "image/exr_header.h"

namespace skywave {

// Returns the decoded size of `stored` [bytes], or -1 if it cannot be decoded or holds more than
// `most` bytes. RLE, ZIPS and ZIP are decoded here; for the others, which the library checks
// itself, the result is `most`.
std::int64_t DecodedSize(ExrCompression compression, std::string_view stored, std::int64_t most);

}  // namespace skywave
