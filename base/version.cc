#include "base/version.h"

namespace skywave {

std::string_view Version() { return SKYWAVE_VERSION; }

}  // namespace skywave
