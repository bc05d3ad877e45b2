// The options of one picture of a batch, by their names, and the request that they make.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/picture_request.h"

namespace skywave {

// An option as a job file gives it. Names of files are those that can be opened.
struct PictureOption {
  std::string name, text;
  std::size_t line = 0;  // of the job file
};

// Returns the request of `options`. Throws InputError with the line of `path`, the job file, for a
// bad value and for options that do not go together.
PictureRequest RequestOf(const std::string& path, const std::vector<PictureOption>& options);

// Returns "why" with the line of the option of `options` that `error` names.
InputError AtOption(const std::string& path, const std::vector<PictureOption>& options,
                    const OptionError& error);

}  // namespace skywave
