// The version of Skywave.
#pragma once

#include <string_view>

namespace skywave {

// Returns "0.1.0", that of CMakeLists.txt.
std::string_view Version();

}  // namespace skywave
