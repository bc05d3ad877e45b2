// The library reports bad input here: InputErrors of the engine become Errors.
#pragma once

#include "kernels/targets.h"
#include "skywave/skywave.h"

namespace skywave::api {

// Throws an Error (kUsage) with `place` and `reason` if `condition` is false.
void Require(bool condition, const std::string& place, const std::string& reason);

// Has to be called while an exception is handled. Throws an Error for an InputError or for lack of
// memory, Canceled for RenderCanceled, and any other exception unchanged. The engine's exception is
// nested in the Error (std::rethrow_if_nested).
[[noreturn]] void RethrowTranslated();

// Returns what `work` returns, and translates the exceptions that it throws. Throws
// std::runtime_error instead of calling it on a processor that cannot run the kernels.
template <class Work>
auto Translated(const Work& work) {
  RequireKernelTarget();
  try {
    return work();
  } catch (...) {
    RethrowTranslated();
  }
}

}  // namespace skywave::api
