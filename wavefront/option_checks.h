// What an integrator refuses.
#pragma once

#include "wavefront/frame.h"

namespace skywave {

// Throws InputError where options do not go together with their integrator.
void CheckIntegrator(const RenderOptions& options);

}  // namespace skywave
