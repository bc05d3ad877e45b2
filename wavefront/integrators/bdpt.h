// Bidirectional path tracing: what vertex connection and merging shares with it (bdpt.cc).
#pragma once

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

void RenderBdptWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// The tables that connections need.
void AddConnectionTables(const RenderOptions& options, Worker& worker);

// Throws OptionError where sub-paths cannot be connected under these options.
void CheckConnections(const RenderOptions& options);

}  // namespace skywave
