// Where the program under test and the sources are. Only one unit is compiled with these paths, so
// the objects of all others are the same in every checkout.
#pragma once

#include <string>

namespace skywave {

// The path of the program `skywave` of this build.
std::string ProgramPath();

// The path of a file of the source tree; `name` is relative to its root.
std::string SourcePath(const std::string& name);

}  // namespace skywave
