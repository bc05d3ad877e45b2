// Parts of bidirectional path tracing (bdpt.cc) that vertex connection and merging shares.
#pragma once

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

void RenderBdptWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Adds the tables that connections need.
void AddConnectionTables(const RenderOptions& options, Worker& worker);

// Throws OptionError if sub-paths cannot be connected with these options.
void CheckConnections(const RenderOptions& options);

}  // namespace skywave
