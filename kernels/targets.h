// These functions describe the instruction set that the kernels run on.
#pragma once

#include <cstdint>
#include <string>

namespace skywave {

// Throws std::runtime_error if this processor has no instruction set that the kernels are compiled
// for; without one they must not be called.
void RequireKernelTarget();
// Returns Highway's name of the best instruction set that this processor has and the kernels are
// compiled for.
std::string KernelTarget();
// Returns the number of rows that a kernel processes at once there.
std::uint32_t KernelLanes();
std::string HighwayVersion();

}  // namespace skywave
