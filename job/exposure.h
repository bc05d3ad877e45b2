// The exposure and tone curve of the PNG of a picture: a request like that of a job, and its
// options.
#pragma once

#include <vector>

#include "image/image.h"
#include "job/option.h"

namespace skywave {

struct ExposureRequest {
  ToneMapping tone;
  PhotographicExposure photo;  // shutter_seconds 0: no camera is simulated
};

// Returns the options exposure, shutter, f-number, iso and tone.
std::vector<OptionOf<ExposureRequest>> ExposureOptions();

// Returns the exposure and curve of the PNG, with the exposure of the camera added.
ToneMapping Tone(const ExposureRequest& request);

}  // namespace skywave
