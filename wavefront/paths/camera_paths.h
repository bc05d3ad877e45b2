// Follows paths from the camera, or from surfaces that others have left.
#pragma once

#include <cstdint>

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/worker.h"

namespace skywave {

// Traces paths from a bounce on: rays [0, n) of worker.rays[0] arrive at `bounce` from `first`.
// Returns the bounce at which the last path ended. `film` keeps what KeepAovs gives it of paths
// that begin at the camera, and is null for others.
std::uint32_t FollowPaths(const FrameView& frame, const Departure& first, std::uint32_t n,
                          std::uint32_t bounce, Worker& worker, Film* film, StageClock& clock);

}  // namespace skywave
