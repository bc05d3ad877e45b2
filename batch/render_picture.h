// Renders one picture of a batch and writes its files.
#pragma once

#include <cstdint>
#include <functional>

#include "batch/run.h"
#include "job/watch.h"

namespace skywave {

// Who watches a picture; each function may be empty.
struct PictureWatcher {
  std::function<void(std::uint64_t samples)> begin;  // rendering begins, of so many samples
  Teller tell;                                       // see Watch
};

// Renders a picture of `plan` from nothing and writes the EXR and the PNG. Throws InputError, and
// RenderCanceled.
PictureResult RenderAlone(const BatchPlan& plan, const BatchPicture& picture,
                          const PictureWatcher& watcher);

}  // namespace skywave
