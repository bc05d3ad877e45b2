#include "wavefront/render.h"

#include <tbb/task_arena.h>
#include <time.h>

#include <algorithm>
#include <new>

#include "base/clock.h"
#include "wavefront/guiding/emission_guide.h"
#include "wavefront/integrators/integrator.h"
#include "wavefront/option_checks.h"
#include "wavefront/photons/merging_pass.h"
#include "wavefront/photons/photon_pass.h"
#include "wavefront/worker_pool.h"

namespace skywave {
namespace {

void RenderTile(const FrameView& frame, const Tile& tile, Worker& worker, Film& film) {
  const std::uint64_t total =
      std::uint64_t(tile.width) * tile.height * frame.options.samples_per_pixel;
  for (std::uint64_t first = 0; first < total; first += frame.options.wave) {
    const WaveRange range = {
        .tile = tile,
        .first = first,
        .count = std::uint32_t(std::min<std::uint64_t>(frame.options.wave, total - first))};
    RenderWave(frame, range, worker, film);
  }
}

// Of the process, all threads together.
double ProcessorSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// Samples of a tile that are in the picture.
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
    RenderTile(view, tiles[i], worker, film);
    const std::uint64_t samples = CountSamples(view, tiles[i]);
    worker.stats.samples += samples;
    if (progress != nullptr) *progress += samples;
  });
}

}  // namespace

void RenderWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film) {
  switch (frame.options.integrator) {
    case Integrator::kDirect:
      return RenderDirectWave(frame, range, worker, film);
    case Integrator::kPath:
      if (worker.continuations) return RenderSplitWave(frame, range, worker, film);
      return RenderPathWave(frame, range, worker, film);
    case Integrator::kLight:
      return RenderLightWave(frame, range, worker, film);
    case Integrator::kBdpt:
    case Integrator::kVcm:
      return RenderBdptWave(frame, range, worker, film);
    case Integrator::kPhoton:
      return RenderPhotonWave(frame, range, worker, film);
  }
}

int AvailableThreads() { return tbb::this_task_arena::max_concurrency(); }

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

namespace {

// What a pass stores of light paths.
PhotonMaps TracePass(const FrameView& frame, const MergePlan& plan, const PhotonPass& pass,
                     WorkerPool& pool) {
  try {
    if (frame.options.integrator != Integrator::kVcm) {
      return TracePhotons(frame, pass, pool);
    }
    PhotonMaps maps;
    maps.indirect = TraceVertices(frame, plan, pass, pool);
    return maps;
  } catch (const std::bad_alloc&) {
    RefusePhotons(frame.options, "there is no memory left for so many");
  }
}

}  // namespace

void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const std::function<void(const FrameView&)>& render) {
  if (!HasPhotons(frame.options.integrator)) return render(frame);
  const bool merges = frame.options.integrator == Integrator::kVcm;
  const MergePlan plan = merges ? PlanMerging(frame, pool) : MergePlan{};
  float caustic_radius = 0, indirect_radius = 0;  // of the first pass
  for (const PhotonPass& pass : PhotonPasses(frame.options)) {
    const auto start = Clock::now();
    FrameView view = frame;
    if (merges) view.eta_vcm = plan.MergedArea(pass);
    PhotonMaps maps = TracePass(view, plan, pass, pool);
    if (!merges) {
      if (caustic_radius == 0) caustic_radius = maps.caustic.radius;
      if (indirect_radius == 0) indirect_radius = maps.indirect.radius;
      maps.caustic.radius = caustic_radius * pass.shrink;
      maps.indirect.radius = indirect_radius * pass.shrink;
    }
    counts.Add(maps, SecondsSince(start));
    view.photons = &maps;
    view.options.first_sample = pass.first_sample;
    view.options.samples_per_pixel = pass.samples;
    render(view);
  }
}

FrameResult RenderFrame(const FrameView& wanted, Film& film, Progress* progress,
                        std::vector<RayRecorder>* recorders) {
  FrameView frame = wanted;
  frame.options.wave = WholeBeams(wanted.options.wave);
  const RenderOptions& options = frame.options;
  WorkerPool pool(options, recorders);

  FrameResult result;
  const double processor_start = ProcessorSeconds();
  const auto start = Clock::now();
  pool.Run([&] {
    EmissionGuide guide;
    if (options.guide && HasLightPaths(options.integrator) && frame.has_environment()) {
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
