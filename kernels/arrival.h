// How likely light paths (kernels/emission.h) are to arrive where light samples are taken or light
// is met: their density given where on their light they start, but for the cosine at the surface
// where they arrive [1/length^2]. What weights of bidirectional paths need of lights.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/emission.h"
#include "kernels/local_lights.h"

namespace skywave {

// Light of the sky has SkyArrivals (kernels/emission_guide.h).

// Rows [0, n) whose u picks a light: of the sample that SampleLocalLights (for one pick a surface)
// has put into `samples`. The others, which have a sample of the sky, are left as they are.
void SampleArrivals(const LocalLightView& view, const LightChoice& choice,
                    const SceneSphere& sphere, const SurfaceColumns& surfaces, const float* u,
                    const LightColumns& samples, std::uint32_t n, float* arrival);

}  // namespace skywave
