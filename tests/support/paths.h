// Locates the program under test and the sources. Only one unit is compiled with these paths, so
// that the objects of all others are identical in every checkout.
#pragma once

#include <string>

namespace skywave {

// Returns the path of the program `skywave` of this build.
std::string ProgramPath();

// Returns the path of a file in the source tree; `name` is relative to its root.
std::string SourcePath(const std::string& name);

}  // namespace skywave
