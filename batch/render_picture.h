// Renders one picture of a batch and writes its files.
#pragma once

#include "batch/run.h"
#include "job/watch.h"

namespace skywave {

// Renders a picture of `plan` from nothing and writes the EXR and the PNG. `tell`, if there is one,
// is told the share of the samples that is done. Throws InputError, and RenderCanceled.
PictureResult RenderAlone(const BatchPlan& plan, const BatchPicture& picture, const Teller& tell);

}  // namespace skywave
