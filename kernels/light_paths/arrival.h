// How likely light paths (kernels/light_paths/emission.h) are to arrive where light samples are
// taken or light is met: their density given where on their light they start, but for the cosine at
// the surface where they arrive [1/length^2]. What weights of bidirectional paths need of lights.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lights/local_lights.h"

namespace skywave {

// Rows [0, n) whose u picks a light that is somewhere: of the sample that SampleLocalLights (for
// one pick a surface) has put into `samples`. The others, which have a sample of something
// infinitely far away, keep what EnvironmentArrivals (kernels/light_paths/emission_guide.h) says of
// it.
void SampleArrivals(const LocalLightView& view, const LightChoice& choice,
                    const SurfaceColumns& surfaces, const float* u, const LightColumns& samples,
                    std::uint32_t n, float* arrival);

}  // namespace skywave
