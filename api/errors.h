// Bad input as the library reports it: InputErrors of the program become Errors.
#pragma once

#include "skywave/skywave.h"

namespace skywave::api {

// Throws an Error that `place` and `reason` describe where `condition` is false.
void Require(bool condition, const std::string& place, const std::string& reason);

// Has to be called while an exception is handled: throws an Error for an InputError and lack of
// memory, Canceled for RenderCanceled, and everything else as it is. The program's exception is
// nested in the library's (std::rethrow_if_nested).
[[noreturn]] void RethrowTranslated();

// Returns what `work` returns; its exceptions are those of the library.
template <class Work>
auto Translated(const Work& work) {
  try {
    return work();
  } catch (...) {
    RethrowTranslated();
  }
}

}  // namespace skywave::api
