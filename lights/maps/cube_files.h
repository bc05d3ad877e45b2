// A cube map can be stored as six files, one per face.
#pragma once

#include <array>
#include <string>

#include "image/image.h"

namespace skywave {

// "map.exr" names map-right.exr, map-left.exr, map-up.exr, map-down.exr, map-front.exr and
// map-back.exr: the squares of Projection::kCubeStrip.
std::array<std::string, 6> CubeFacePaths(const std::string& path);

// These throw InputError if a file cannot be read or written, or the six are not squares of one
// size.
Image ReadCubeFaces(const std::string& path, const ReadLimits& limits = {});
void WriteCubeFaces(const std::string& path, const Image& strip);

}  // namespace skywave
