// Checks of options against their integrator.
#pragma once

#include "wavefront/frame.h"

namespace skywave {

// Throws OptionError if options do not go together with their integrator and with policies.
void CheckIntegrator(const RenderOptions& options);

}  // namespace skywave
