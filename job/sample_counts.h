// Where the light samples of a render fall on its map (T figure 7.3).
#pragma once

#include "image/image.h"
#include "job/job.h"

namespace skywave {

// Renders the picture of a job and returns how often each texel of its map was sampled, in all
// three channels: the samples of light from there that could bring light, whose shadow rays are
// traced. Those of directional lights that stand for a part of the map count where the lights are.
Image CountSamples(const RenderJob& job);

}  // namespace skywave
