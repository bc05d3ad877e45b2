// Checks of options against their integrator.
#pragma once

#include <cstdint>
#include <string>

#include "wavefront/frame.h"

namespace skywave {

// Throws OptionError if options do not go together with their integrator.
void CheckIntegrator(const RenderOptions& options);

// Throws OptionError if what is stored of light paths would not fit into `memory` [bytes].
void CheckPhotonMemory(const RenderOptions& options, std::uint64_t memory);

// Throws the same error for memory that could not be allocated.
[[noreturn]] void RefusePhotons(const RenderOptions& options, const std::string& why);

}  // namespace skywave
