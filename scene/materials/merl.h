// The MERL database (Matusik, Pfister, Brand and McMillan 2003, "A Data-Driven Reflectance Model")
// has a format for measured BRDFs: three 32-bit integers, 90 90 180, and 90 * 90 * 180 * 3 doubles,
// all red ones first, little-endian.
#pragma once

#include <string>
#include <string_view>

#include "scene/scene.h"

namespace skywave {

// Reads such a file, and throws InputError for other dimensions, other lengths of the file and
// values that are not finite. Negative values mark what was not measured and become 0. The lobe for
// sampling is fitted to the falloff of the half angle.
MeasuredBrdf ReadMerl(const std::string& path);

// The same from memory; `path` is for messages.
MeasuredBrdf ParseMerl(std::string_view bytes, const std::string& path);

}  // namespace skywave
