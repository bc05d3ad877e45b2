// Path tracing (path.cc) and its mode in which paths split (split.cc), which direct light has too.
#pragma once

#include <cstdint>
#include <span>

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

// A worker needs these tables as well where paths split. A continuation has the row of its path:
// one wave follows the first continuation of every path, the next one the second, so the order in
// which a path gathers light is the same for every size of waves.
struct Continuations {
  explicit Continuations(std::uint32_t rows) : wave(rows), direct(rows) {}

  // The current continuations. The radiance of their paths is the sum over all so far, without what
  // their first rays see, which is in `direct`.
  Worker wave;
  soa::Table<RadianceColumns> direct;  // sums over the continuations of a path
};

// What path tracing and direct light have in common: their options, and the tables of a worker.
std::span<const RenderOption> PathOptions();
void AddPathTables(const RenderOptions& options, Worker& worker);

void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);
void RenderSplitWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

}  // namespace skywave
