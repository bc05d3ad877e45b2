// Renders one picture of a batch and writes its files.
#pragma once

#include <cstdint>
#include <functional>

#include "batch/run.h"
#include "job/watch.h"

namespace skywave {

// Runs `work`, whose progress grows to `total` samples, and shows the progress (Watch).
using ShowWork = std::function<void(std::uint64_t total, const WatchedWork& work)>;

// Renders a picture of `plan` from nothing and writes the EXR and the PNG. Throws InputError.
PictureResult RenderAlone(const BatchPlan& plan, const BatchPicture& picture, const ShowWork& show);

}  // namespace skywave
