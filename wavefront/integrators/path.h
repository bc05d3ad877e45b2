// Path tracing (path.cc) and its mode in which paths split (split.cc).
#pragma once

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);
void RenderSplitWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

}  // namespace skywave
