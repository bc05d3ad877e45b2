#include "tests/support/paths.h"

namespace skywave {

std::string ProgramPath() { return SKYWAVE_PROGRAM; }

std::string SourcePath(const std::string& name) { return SKYWAVE_SOURCE "/" + name; }

}  // namespace skywave
