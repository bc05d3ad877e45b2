// Which sources this program was built from.
#pragma once

#include <string>

namespace skywave {

// The revision of git when the program was linked, with "-dirty" behind it where files differed
// from it; "unknown" without git. Written by cmake/revision.cmake at every build, so that one small
// file is compiled again and nothing else.
std::string GitRevision();

}  // namespace skywave
