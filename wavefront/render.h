// Renders a whole frame: cuts the film into tiles, gives them to workers, adds up their statistics.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/guiding/guide_counts.h"
#include "wavefront/integrators/integrators.h"
#include "wavefront/photons/photon_pass.h"
#include "wavefront/rays/ray_recorder.h"
#include "wavefront/stages/stages.h"
#include "wavefront/stats.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// What the thread that watches a render shares with it.
struct Progress {
  std::atomic<std::uint64_t> samples = 0;  // finished ones: the watcher reads it
  std::atomic<bool> cancel = false;        // the watcher sets it: the render throws RenderCanceled
};

struct FrameResult {
  RenderStats stats;
  PhotonCounts photons;
  GuideCounts guide;             // its seconds are among `seconds`
  double seconds = 0;            // wall clock, from the first wave to the last
  double processor_seconds = 0;  // of all threads of the process meanwhile
  int threads = 0;
};

// Renders every sample of `frame` into `film`. Bits of the film depend on neither threads, wave nor
// backend. Throws RenderCanceled, after which the film holds some of the samples. `recorders`, if
// not null, gets a recorder for each thread, with the rays of its tiles in order, for a replay.
FrameResult RenderFrame(const FrameView& frame, Film& film, Progress* progress = nullptr,
                        std::vector<RayRecorder>* recorders = nullptr);

// Renders the samples of a wave with the worker's tables, which are those of the integrator.
void RenderWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Calls `render` for each pass of a frame, whose photons it traces before, with the frame as the
// samples of the pass see it; once with the frame itself where there are none.
void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render);

// Returns the tiles of a film in the order in which they are begun. They are large enough for a
// tile to fill several waves, if that is possible, and small enough to be shared out evenly.
std::vector<Tile> CutTiles(std::uint32_t width, std::uint32_t height,
                           std::uint32_t samples_per_pixel, std::uint32_t wave);

}  // namespace skywave
