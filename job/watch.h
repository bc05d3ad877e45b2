// Runs long work on another thread, while the calling thread reports its progress.
#pragma once

#include <cstdint>
#include <functional>

#include "wavefront/render.h"

namespace skywave {

// Such work adds to the samples of its Progress and throws RenderCanceled once that is canceled.
using WatchedWork = std::function<void(Progress& progress)>;

// A teller is given the share that is done, in [0, 1], and returns false to cancel the work.
using Teller = std::function<bool(double done)>;

// Runs `work`, whose Progress grows to `total` samples, and calls `tell`, if there is one, about
// ten times a second from the calling thread. Once the work has ended, throws what the work threw,
// else what `tell` threw, else RenderCanceled if `tell` returned false.
void Watch(std::uint64_t total, const WatchedWork& work, const Teller& tell);
// The same with a Progress that `tell` may use too.
void Watch(Progress& progress, std::uint64_t total, const WatchedWork& work, const Teller& tell);

}  // namespace skywave
