// Identifies the sources from which this program was built.
#pragma once

#include <string>

namespace skywave {

// Returns the git revision at link time, followed by "-dirty" if files differed from it; "unknown"
// without git. cmake/revision.cmake writes it at every build, so that only one small file is
// recompiled.
std::string GitRevision();

}  // namespace skywave
