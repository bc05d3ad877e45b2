// Renders a whole frame: cuts the film into tiles, gives them to workers, adds up their statistics.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/integrator.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/pilot_reports.h"
#include "wavefront/rays/ray_recorder.h"
#include "wavefront/stages/stages.h"
#include "wavefront/stats.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// What the thread that watches a render shares with it. The watcher reads `samples` and sets the
// others.
struct Progress {
  std::atomic<std::uint64_t> samples = 0;  // in the film, counted when their tile is finished
  std::atomic<std::uint64_t> spared = 0;   // those that are expected not to be rendered
  std::atomic<bool> pause = false;   // the render calls RenderControl::at_pause, then resets it
  std::atomic<bool> cancel = false;  // the render throws RenderCanceled
};

// How far a render has come. A render goes step by step; the film holds all samples before the
// current step and, of the samples of this step, the first rows[i] rows of tile i of CutStep.
struct RenderState {
  SampleRange step;
  std::uint32_t tile_side = 0;      // of the step [pixels]
  std::vector<std::uint64_t> rows;  // empty: the step has not begun
  // The end of the samples of each block of beams that gets no more, row by row; 0: it goes on.
  // Empty: all go on.
  std::vector<std::uint32_t> ended;
};

// How the caller of a render takes part in it. All members may be left out.
struct RenderControl {
  Progress* progress = nullptr;
  // Gets a recorder for each thread, with the rays of its tiles in order, for a replay.
  std::vector<RayRecorder>* recorders = nullptr;
  // Called when the film holds all samples before `done` and nothing else. Returns where the next
  // step ends, or `done` if the render is to end here. Without it, one step has all samples.
  std::function<std::uint32_t(std::uint32_t done)> next_stop;
  // Called before next_stop, at each such place. It may end blocks: then they have
  // state.ended[block] = state.step.first, and the render ends once all of them have ended.
  std::function<void(RenderState& state)> end_blocks;
  // Called while all threads rest, once the watcher has set Progress::pause.
  std::function<void(const RenderState& state)> at_pause;
  // Called by the thread that has added all samples of a step to a tile; its pixels then hold those
  // of the frame before `done`. Other tiles are being rendered meanwhile.
  std::function<void(const Tile& tile, std::uint32_t done)> on_tile;
};

struct FrameResult {
  RenderStats stats;
  PhotonCounts photons;
  PilotReports pilots;           // whose seconds are among `seconds`
  double seconds = 0;            // wall clock, from the first wave to the last
  double processor_seconds = 0;  // of all threads of the process meanwhile
  int threads = 0;
  std::uint32_t samples_per_pixel = 0;  // in the film, if the frame's were not there before
  // Where blocks end apart, pixels have fewer than that on average.
  double mean_samples_per_pixel = 0;
  double ended_blocks = 0;  // share of the blocks that end_blocks has ended
};

// Renders the samples of `frame` into `film`. Bits of the film depend on neither threads, wave,
// backend nor steps. Throws RenderCanceled.
FrameResult RenderFrame(const FrameView& frame, Film& film, const RenderControl& control = {});
// Goes on from `state`, which describes what is already in the film, and keeps it up to date: also
// after an exception it describes what the film holds.
FrameResult RenderFrame(const FrameView& frame, Film& film, RenderState& state,
                        const RenderControl& control = {});

// Renders the samples of a wave with the worker's tables, which are those of the integrator.
void RenderWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Calls `render` for each pass of a frame, whose photons it traces before, with the frame as the
// samples of the pass see it; once with the frame itself where there are none.
void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render);

// Returns the side of the tiles of a step. They are large enough for a tile to fill several waves,
// if that is possible, and small enough to be shared out evenly.
std::uint32_t TileSide(std::uint32_t samples_per_pixel, std::uint32_t wave);

// Returns the tiles of a film in the order in which they are begun.
std::vector<Tile> CutTiles(std::uint32_t width, std::uint32_t height, std::uint32_t side);

// A tile of a step and those of its blocks that go on, as in WaveRange.
struct TileOfStep {
  Tile tile;
  std::vector<std::uint32_t> blocks;  // empty: all, or none if there are no rows
  std::uint64_t rows = 0;             // of the step
};
// Returns the tiles of the step of `state`, whose tile_side is set, in the film of `camera`.
std::vector<TileOfStep> CutStep(const CameraView& camera, const RenderState& state);

// Returns how many blocks of beams the film of a camera has.
std::size_t CountBlocks(const CameraView& camera);

// Returns how many samples of each pixel of the film, row by row, a film holds that has come to
// `state`.
std::vector<std::uint32_t> SamplesByPixel(const FrameView& frame, const RenderState& state);

}  // namespace skywave
