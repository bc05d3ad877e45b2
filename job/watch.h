// Long work on another thread, while this one tells somebody how far it is.
#pragma once

#include <cstdint>
#include <functional>

#include "wavefront/render.h"

namespace skywave {

// Work that adds to the samples of its Progress and throws RenderCanceled where that says so.
using WatchedWork = std::function<void(Progress& progress)>;

// Is told the share that is done, in [0, 1], and returns false if the work is to end.
using Teller = std::function<bool(double done)>;

// Runs `work`, whose Progress grows to `total`, and calls `tell`, if there is one, about ten times
// a second from the calling thread. Throws RenderCanceled where `tell` returned false, what `tell`
// threw once the work has ended, or what the work throws.
void Watch(std::uint64_t total, const WatchedWork& work, const Teller& tell);

}  // namespace skywave
