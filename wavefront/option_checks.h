// What an integrator refuses.
#pragma once

#include <cstdint>
#include <string>

#include "wavefront/frame.h"

namespace skywave {

// Throws OptionError where options do not go together with their integrator.
void CheckIntegrator(const RenderOptions& options);

// Throws OptionError where what is stored of light paths would not fit in `memory` [bytes].
void CheckPhotonMemory(const RenderOptions& options, std::uint64_t memory);

// The same for memory that was not to be had when it was asked for.
[[noreturn]] void RefusePhotons(const RenderOptions& options, const std::string& why);

}  // namespace skywave
