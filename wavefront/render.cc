#include "wavefront/render.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "base/clock.h"
#include "base/counted_region.h"
#include "wavefront/integrator.h"
#include "wavefront/policy.h"
#include "wavefront/worker_pool.h"

namespace skywave {
namespace {

// Renders the rows of `tile` from `rows` on and after each wave updates `rows`. Returns early if
// the render is to pause.
void RenderTile(const FrameView& frame, const TileOfStep& tile, const WorkerPool& pool,
                const Progress* progress, Worker& worker, Film& film, std::uint64_t& rows) {
  while (rows < tile.rows) {
    pool.CheckCanceled();
    if (progress != nullptr && progress->pause) return;
    const WaveRange range = {
        .tile = tile.tile,
        .first = rows,
        .count = std::uint32_t(std::min<std::uint64_t>(frame.options.wave, tile.rows - rows)),
        .blocks = tile.blocks};
    RenderWave(frame, range, worker, film);
    rows += range.count;
  }
}

// Returns the time of all threads of the process together.
double ProcessorSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// Returns how many pixels of a part of the film are in the picture.
std::uint64_t CountPixels(const FrameView& frame, const Tile& part) {
  const RenderOptions& options = frame.options;
  const CropWindow inside =
      Intersection({int(part.x), int(part.y), int(part.width), int(part.height)},
                   {options.crop_x - int(frame.camera.first_column),
                    options.crop_y - int(frame.camera.first_row), options.width, options.height});
  return std::uint64_t(inside.width) * std::uint64_t(inside.height);
}

// Returns block `index` of a tile.
Tile BlockOf(const Tile& tile, std::uint32_t index) {
  const std::uint32_t across = tile.width / kBeamWidth;
  return {tile.x + index % across * kBeamWidth, tile.y + index / across * kBeamHeight, kBeamWidth,
          kBeamHeight};
}

// Returns how many pixels of the picture a step renders in a tile.
std::uint64_t CountPixels(const FrameView& frame, const TileOfStep& tile) {
  if (tile.blocks.empty()) return CountPixels(frame, tile.tile);
  std::uint64_t pixels = 0;
  for (const std::uint32_t block : tile.blocks) {
    pixels += CountPixels(frame, BlockOf(tile.tile, block));
  }
  return pixels;
}

// Returns the frame with the samples of `range` alone.
FrameView WithSamples(const FrameView& frame, const SampleRange& range) {
  FrameView view = frame;
  view.options.first_sample = range.first;
  view.options.samples_per_pixel = range.count();
  return view;
}

// Renders what is missing of the step that `state` describes.
void RenderStep(const FrameView& frame, WorkerPool& pool, Film& film, RenderState& state,
                const RenderControl& control) {
  const FrameView of_step = WithSamples(frame, state.step);
  const std::vector<TileOfStep> tiles = CutStep(frame.camera, state);
  const auto missing = [&](std::size_t i) { return state.rows[i] < tiles[i].rows; };
  const auto render_tile = [&](std::size_t i, Worker& worker, RayRecorder* recorder) {
    if (!missing(i)) return;
    FrameView view = of_step;
    view.tracer.recorder = recorder;
    const std::uint64_t before = state.rows[i];
    RenderTile(view, tiles[i], pool, control.progress, worker, film, state.rows[i]);
    const double share = double(state.rows[i] - before) / double(tiles[i].rows);
    const std::uint64_t samples = CountPixels(view, tiles[i]) * state.step.count();
    const auto rendered = std::uint64_t(std::llrint(share * double(samples)));
    worker.stats.samples += rendered;
    if (control.progress != nullptr) control.progress->samples += rendered;
    if (control.on_tile && !missing(i)) control.on_tile(tiles[i].tile, state.step.end);
  };
  std::size_t first = 0;  // tile of which something is missing
  do {
    pool.ForEach(tiles.size() - first, [&](std::size_t i, Worker& worker, RayRecorder* recorder) {
      render_tile(first + i, worker, recorder);
    });
    if (control.progress != nullptr && control.progress->pause) {
      if (control.at_pause) control.at_pause(state);
      control.progress->pause = false;
    }
    while (first < tiles.size() && !missing(first)) ++first;
  } while (first < tiles.size());
}

// Returns how many samples of the picture are in the film.
std::uint64_t SamplesInPicture(const FrameView& frame, const RenderState& state) {
  const RenderOptions& options = frame.options;
  const std::vector<std::uint32_t> by_pixel = SamplesByPixel(frame, state);
  std::uint64_t samples = 0;
  for (int y = 0; y < options.height; ++y) {
    const int row = options.crop_y - int(frame.camera.first_row) + y;
    const auto first = by_pixel.begin() + std::ptrdiff_t(row) * std::ptrdiff_t(frame.camera.width) +
                       (options.crop_x - int(frame.camera.first_column));
    samples = std::accumulate(first, first + options.width, samples);
  }
  return samples;
}

// Returns the share of the blocks that have ended.
double EndedShare(const RenderState& state) {
  if (state.ended.empty()) return 0;
  const auto going = std::count(state.ended.begin(), state.ended.end(), 0u);
  return 1 - double(going) / double(state.ended.size());
}

// Renders the samples of `range`, step by step. Returns false if the render is to end before the
// end of the range.
bool RenderSteps(const FrameView& frame, const SampleRange& range, WorkerPool& pool, Film& film,
                 RenderState& state, const RenderControl& control) {
  while (state.step.first < range.end) {
    if (state.rows.empty()) {
      if (control.end_blocks) control.end_blocks(state);
      const double going = 1 - EndedShare(state);
      if (going <= 0) return false;
      const std::uint32_t done = state.step.first;
      const std::uint32_t stop = control.next_stop ? control.next_stop(done) : range.end;
      if (stop <= done) return false;
      state.step.end = std::min(stop, range.end);
      const double in_mean = std::ceil(going * double(state.step.count()));
      state.tile_side = TileSide(std::uint32_t(in_mean), frame.options.wave);
      state.rows.resize(CutTiles(frame.camera.width, frame.camera.height, state.tile_side).size());
    }
    RenderStep(frame, pool, film, state, control);
    state = {.step = {state.step.end, state.step.end},
             .tile_side = 0,
             .rows = {},
             .ended = std::move(state.ended)};
  }
  return true;
}

}  // namespace

void RenderWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film) {
  Describe(frame.options.integrator).render_wave(frame, range, worker, film);
}

std::uint32_t TileSide(std::uint32_t samples_per_pixel, std::uint32_t wave) {
  std::uint32_t side = 8;
  while (side < 64 && std::uint64_t(side) * side * samples_per_pixel < 4ull * wave) side *= 2;
  return side;
}

std::vector<Tile> CutTiles(std::uint32_t width, std::uint32_t height, std::uint32_t side) {
  std::vector<Tile> tiles;
  for (std::uint32_t y = 0; y < height; y += side) {
    for (std::uint32_t x = 0; x < width; x += side) {
      tiles.push_back({x, y, std::min(side, width - x), std::min(side, height - y)});
    }
  }
  return tiles;
}

std::size_t CountBlocks(const CameraView& camera) {
  return std::size_t{camera.width} * camera.height / kBeamRays;
}

std::vector<TileOfStep> CutStep(const CameraView& camera, const RenderState& state) {
  std::vector<TileOfStep> tiles;
  for (const Tile& tile : CutTiles(camera.width, camera.height, state.tile_side)) {
    TileOfStep of_step = {.tile = tile, .blocks = {}};
    std::uint32_t blocks = tile.width * tile.height / kBeamRays;
    if (!state.ended.empty()) {
      for (std::uint32_t i = 0; i < blocks; ++i) {
        const Tile block = BlockOf(tile, i);
        const std::size_t of_film =
            std::size_t{block.y / kBeamHeight} * (camera.width / kBeamWidth) + block.x / kBeamWidth;
        if (state.ended[of_film] == 0) of_step.blocks.push_back(i);
      }
      blocks = std::uint32_t(of_step.blocks.size());
    }
    of_step.rows = std::uint64_t{blocks} * kBeamRays * state.step.count();
    tiles.push_back(std::move(of_step));
  }
  return tiles;
}

std::vector<std::uint32_t> SamplesByPixel(const FrameView& frame, const RenderState& state) {
  const std::uint32_t width = frame.camera.width, height = frame.camera.height;
  const std::uint32_t first = frame.options.first_sample;
  std::vector<std::uint32_t> samples(std::size_t{width} * height, state.step.first - first);
  const auto for_each_pixel = [&](const Tile& block, auto f) {
    for (std::uint32_t i = 0; i < kBeamRays; ++i) {
      f(samples[std::size_t(block.y + i / kBeamWidth) * width + block.x + i % kBeamWidth]);
    }
  };
  const Tile film = {0, 0, width, height};
  for (std::size_t i = 0; i < state.ended.size(); ++i) {
    const std::uint32_t end = state.ended[i];
    if (end == 0) continue;
    for_each_pixel(BlockOf(film, std::uint32_t(i)), [&](std::uint32_t& n) { n = end - first; });
  }
  if (state.rows.empty()) return samples;
  const std::vector<TileOfStep> tiles = CutStep(frame.camera, state);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    // The samples of a block follow each other, and then come those of the next block (StartPaths).
    const std::uint64_t per_block = std::uint64_t{kBeamRays} * state.step.count();
    for (std::uint64_t number = 0; number * per_block < state.rows[i]; ++number) {
      const auto& blocks = tiles[i].blocks;
      const std::uint32_t block = blocks.empty() ? std::uint32_t(number) : blocks[number];
      const std::uint64_t rows = std::min(state.rows[i] - number * per_block, per_block);
      for_each_pixel(BlockOf(tiles[i].tile, block),
                     [&](std::uint32_t& n) { n += std::uint32_t(rows / kBeamRays); });
    }
  }
  return samples;
}

void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render) {
  const auto for_each_pass = Describe(frame.options.integrator).for_each_pass;
  if (for_each_pass == nullptr) {
    render(frame);
  } else {
    for_each_pass(frame, pool, counts, render);
  }
}

FrameResult RenderFrame(const FrameView& frame, Film& film, const RenderControl& control) {
  RenderState state;
  return RenderFrame(frame, film, state, control);
}

FrameResult RenderFrame(const FrameView& wanted, Film& film, RenderState& state,
                        const RenderControl& control) {
  const SampleRange samples = SamplesOf(wanted.options);
  if (state.step.end == 0) state.step = {samples.first, samples.first};
  if (control.progress != nullptr) control.progress->samples += SamplesInPicture(wanted, state);
  // The rest of a frame is a later range of the same picture.
  FrameView frame = WithSamples(wanted, {state.step.first, samples.end});
  frame.options.picture_samples = PictureSamples(wanted.options);
  frame.options.wave = WholeBeams(wanted.options.wave);
  const RenderOptions& options = frame.options;
  Progress* const progress = control.progress;
  WorkerPool pool(options, control.recorders, progress != nullptr ? &progress->cancel : nullptr);

  FrameResult result;
  const double processor_start = ProcessorSeconds();
  const auto start = Clock::now();
  pool.Run([&] {
    const CountedRegion counted;
    const Pilots pilots = {.pool = pool,
                           .brightest_radiance = film.layout().brightest_radiance,
                           .reports = result.pilots};
    std::vector<std::shared_ptr<const void>> learnt;  // the frame refers to it
    for (const PolicyDescriptor& policy : Policies()) {
      if (policy.teach != nullptr) learnt.push_back(policy.teach(frame, pilots));
    }
    ForEachPass(frame, pool, result.photons, [&](const FrameView& view) {
      return RenderSteps(view, SamplesOf(view.options), pool, film, state, control);
    });
  });
  result.seconds = SecondsSince(start);
  result.processor_seconds = ProcessorSeconds() - processor_start;
  result.threads = pool.threads();
  result.stats = pool.stats();
  result.samples_per_pixel = state.step.first - samples.first;
  result.mean_samples_per_pixel =
      double(SamplesInPicture(wanted, state)) / (double(options.width) * options.height);
  result.ended_blocks = EndedShare(state);
  return result;
}

}  // namespace skywave
