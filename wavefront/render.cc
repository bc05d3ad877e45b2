#include "wavefront/render.h"

#include <time.h>

#include <algorithm>
#include <new>

#include "base/clock.h"
#include "wavefront/guiding/emission_guide.h"
#include "wavefront/integrators/integrators.h"
#include "wavefront/option_checks.h"
#include "wavefront/worker_pool.h"

namespace skywave {
namespace {

void RenderTile(const FrameView& frame, const Tile& tile, const WorkerPool& pool, Worker& worker,
                Film& film) {
  const std::uint64_t total =
      std::uint64_t(tile.width) * tile.height * frame.options.samples_per_pixel;
  for (std::uint64_t first = 0; first < total; first += frame.options.wave) {
    pool.CheckCanceled();
    const WaveRange range = {
        .tile = tile,
        .first = first,
        .count = std::uint32_t(std::min<std::uint64_t>(frame.options.wave, total - first))};
    RenderWave(frame, range, worker, film);
  }
}

// Returns the time of all threads of the process together.
double ProcessorSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// Returns how many samples of a tile are in the picture.
std::uint64_t CountSamples(const FrameView& frame, const Tile& tile) {
  const RenderOptions& options = frame.options;
  const auto overlap = [](std::uint32_t begin, std::uint32_t count, std::int64_t picture,
                          int side) {
    const std::int64_t first = std::max<std::int64_t>(begin, picture);
    const std::int64_t end = std::min<std::int64_t>(std::int64_t{begin} + count, picture + side);
    return std::uint64_t(std::max<std::int64_t>(end - first, 0));
  };
  return overlap(tile.x, tile.width, options.crop_x - std::int64_t{frame.camera.first_column},
                 options.width) *
         overlap(tile.y, tile.height, options.crop_y - std::int64_t{frame.camera.first_row},
                 options.height) *
         options.samples_per_pixel;
}

void RenderTiles(const FrameView& frame, WorkerPool& pool, Film& film, Progress* progress) {
  const RenderOptions& options = frame.options;
  const std::vector<Tile> tiles =
      CutTiles(frame.camera.width, frame.camera.height, options.samples_per_pixel, options.wave);
  pool.ForEach(tiles.size(), [&](std::size_t i, Worker& worker, RayRecorder* recorder) {
    FrameView view = frame;
    view.tracer.recorder = recorder;
    RenderTile(view, tiles[i], pool, worker, film);
    const std::uint64_t samples = CountSamples(view, tiles[i]);
    worker.stats.samples += samples;
    if (progress != nullptr) progress->samples += samples;
  });
}

}  // namespace

void RenderWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film) {
  Describe(frame.options.integrator).render_wave(frame, range, worker, film);
}

std::vector<Tile> CutTiles(std::uint32_t width, std::uint32_t height,
                           std::uint32_t samples_per_pixel, std::uint32_t wave) {
  std::uint32_t side = 8;
  while (side < 64 && std::uint64_t(side) * side * samples_per_pixel < 4ull * wave) side *= 2;
  std::vector<Tile> tiles;
  for (std::uint32_t y = 0; y < height; y += side) {
    for (std::uint32_t x = 0; x < width; x += side) {
      tiles.push_back({x, y, std::min(side, width - x), std::min(side, height - y)});
    }
  }
  return tiles;
}

void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render) {
  const auto for_each_pass = Describe(frame.options.integrator).for_each_pass;
  if (for_each_pass == nullptr) return render(frame);
  try {
    for_each_pass(frame, pool, counts, render);
  } catch (const std::bad_alloc&) {
    // Nothing else takes as much memory, whoever asked for the last of it.
    RefusePhotons(frame.options, "there is no memory left for so many");
  }
}

FrameResult RenderFrame(const FrameView& wanted, Film& film, Progress* progress,
                        std::vector<RayRecorder>* recorders) {
  FrameView frame = wanted;
  frame.options.wave = WholeBeams(wanted.options.wave);
  const RenderOptions& options = frame.options;
  WorkerPool pool(options, recorders, progress != nullptr ? &progress->cancel : nullptr);

  FrameResult result;
  const double processor_start = ProcessorSeconds();
  const auto start = Clock::now();
  pool.Run([&] {
    EmissionGuide guide;
    if (options.guide && Describe(options.integrator).has_light_paths() &&
        frame.has_environment()) {
      guide = LearnEmission(frame, pool, result.guide);
      if (!guide.empty()) frame.guide = &guide;
    }
    ForEachPass(frame, pool, result.photons,
                [&](const FrameView& view) { RenderTiles(view, pool, film, progress); });
  });
  result.seconds = SecondsSince(start);
  result.processor_seconds = ProcessorSeconds() - processor_start;
  result.threads = pool.threads();
  result.stats = pool.stats();
  return result;
}

}  // namespace skywave
