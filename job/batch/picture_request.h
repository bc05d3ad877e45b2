// What one picture of a batch asks for: the request of its job, the limits of its render and the
// exposure of its PNG, made from options by their names.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/exposure.h"
#include "job/limits.h"
#include "job/option.h"
#include "job/request.h"

namespace skywave {

// An option as a job file gives it. Names of files are those that can be opened.
struct PictureOption {
  std::string name, text;
  std::size_t line = 0;  // of the job file
};

struct PictureRequest {
  JobRequest job;
  RenderLimits limits;
  ExposureRequest exposure;
  ExrFormat format;
};

// Returns every option of a job, of its limits, exposure and format, bound to `request`.
std::vector<BoundOption> BindPictureOptions(const std::shared_ptr<PictureRequest>& request);

// Returns the request of `options`. Throws InputError with the line of `path`, the job file, for a
// bad value and for options that do not go together.
PictureRequest RequestOf(const std::string& path, const std::vector<PictureOption>& options);

// Returns "why" with the line of the option of `options` that `error` names.
InputError AtOption(const std::string& path, const std::vector<PictureOption>& options,
                    const OptionError& error);

}  // namespace skywave
