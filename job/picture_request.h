// What one picture is: the request of its job, the limits of its render, the exposure of its PNG
// and the format of its EXR. The library, the command line, job files and their shares all fill it
// by the options of one table.
#pragma once

#include <span>

#include "image/image.h"
#include "job/exposure.h"
#include "job/limits.h"
#include "job/request.h"
#include "wavefront/option.h"

namespace skywave {

struct PictureRequest {
  JobRequest job;
  RenderLimits limits;
  ExposureRequest exposure;
  ExrFormat format;
};

// Returns every option of a picture: those of its job, limits, exposure and format, in this order.
std::span<const OptionOf<PictureRequest>> PictureOptions();

}  // namespace skywave
