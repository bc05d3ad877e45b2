// How the PNG next to a picture is exposed: a request like that of a job, and its options.
#pragma once

#include <vector>

#include "image/image.h"
#include "job/option.h"

namespace skywave {

struct ExposureRequest {
  ToneMapping tone;
  PhotographicExposure photo;  // shutter_seconds 0: no camera whose exposure counts
};

std::vector<OptionOf<ExposureRequest>> ExposureOptions();

// Returns the curve of the PNG, including the exposure of the camera.
ToneMapping Tone(const ExposureRequest& request);

}  // namespace skywave
