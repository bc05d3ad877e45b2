// Encodes JPEGs: small pictures inside of reports, where a PNG would be several times as large.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace skywave {

// Returns a baseline JPEG of 8-bit sRGB, `width` * `height` * 3 bytes, rows from the top. `quality`
// is that of libjpeg, in [1, 100]. Throws InputError (kExitIo) for a picture that cannot be one.
std::string EncodeJpeg(int width, int height, const std::vector<std::uint8_t>& rgb, int quality);

}  // namespace skywave
