// Weights of bidirectional paths need the density with which light paths
// (kernels/light_paths/emission.h) arrive where light samples are taken or light is hit: given
// where on their light they start, and without the cosine at the surface where they arrive
// [1/length^2].
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lights/local_lights.h"

namespace skywave {

// Writes `arrival` of those rows [0, n) whose u picks a light at a finite distance: that of the
// sample that SampleLocalLights (for one pick per surface) has put into `samples`. The others,
// whose sample is of something infinitely far away, keep the value of EnvironmentArrivals
// (kernels/light_paths/emission_guide.h).
void SampleArrivals(const LocalLightView& view, const LightChoice& choice,
                    const SurfaceColumns& surfaces, const float* u, const LightColumns& samples,
                    std::uint32_t n, float* arrival);

}  // namespace skywave
