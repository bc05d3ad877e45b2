// Path tracing, and its mode that splits: see path.cc and split.cc.
#pragma once

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);
void RenderSplitWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Path tracing from a bounce on: rays [0, n) of worker.rays[0] arrive at `bounce`, coming from
// `first`. Returns the bounce at which the last path ended. `film`: keeps what KeepAovs says of
// paths that begin at the camera; null for others.
std::uint32_t FollowPaths(const FrameView& frame, const Departure& first, std::uint32_t n,
                          std::uint32_t bounce, Worker& worker, Film* film, StageClock& clock);

}  // namespace skywave
