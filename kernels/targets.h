// What the kernels run on.
#pragma once

#include <cstdint>
#include <string>

namespace skywave {

// Highway's name of the best instruction set that this processor has and the kernels are compiled
// for, and the version of Highway.
std::string KernelTarget();
// Rows that a kernel takes at once there.
std::uint32_t KernelLanes();
std::string HighwayVersion();

}  // namespace skywave
