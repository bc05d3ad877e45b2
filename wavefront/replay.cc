#include "wavefront/replay.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>

#include "wavefront/flush_denormals.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

struct Batch {
  const RayRecorder* recorder;
  RayBatch batch;
};

// Where a thread's results go.
struct Scratch {
  explicit Scratch(std::uint32_t rows) : rays(rows), hits(rows) {}
  soa::Table<RayColumns> rays;
  soa::Table<HitColumns> hits;
  std::uint64_t hit = 0;  // rays that hit something
};

// The recorded columns in place of the table's own; only t_far is written.
RayColumns RecordedRays(const Batch& b, const Scratch& scratch) {
  const auto column = [&](const float* base) { return const_cast<float*>(base) + b.batch.begin; };
  RayColumns rays = scratch.rays;
  rays.org_x = column(b.recorder->org(0));
  rays.org_y = column(b.recorder->org(1));
  rays.org_z = column(b.recorder->org(2));
  rays.dir_x = column(b.recorder->dir(0));
  rays.dir_y = column(b.recorder->dir(1));
  rays.dir_z = column(b.recorder->dir(2));
  std::fill_n(rays.t_far, b.batch.count, std::numeric_limits<float>::infinity());
  return rays;
}

std::uint64_t CountOccluded(const RayColumns& rays, std::uint32_t n) {
  return std::uint64_t(std::count_if(rays.t_far, rays.t_far + n, [](float t) { return t < 0; }));
}

std::uint64_t CountHits(const HitColumns& hits, std::uint32_t n) {
  return n - std::uint64_t(std::count(hits.geom, hits.geom + n, kNoHit));
}

// The wall clock [s]; adds the rays that hit something to `hits`.
double ReplayKind(const Tracer& tracer, const std::vector<Batch>& batches, bool occlusion,
                  tbb::task_arena& arena, std::uint32_t rows, std::uint64_t& hits) {
  // Before the clock starts: allocation and the first touch of memory are not Embree's.
  std::vector<std::unique_ptr<Scratch>> scratch(std::size_t(arena.max_concurrency()));
  for (auto& mine : scratch) mine = std::make_unique<Scratch>(rows);
  const auto start = std::chrono::steady_clock::now();
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, batches.size(), [&](std::size_t i) {
      const auto& mine = scratch[std::size_t(tbb::this_task_arena::current_thread_index())];
      const FlushDenormals flush;
      const RayColumns rays = RecordedRays(batches[i], *mine);
      const std::uint32_t n = batches[i].batch.count;
      const std::uint32_t* keys = batches[i].recorder->keys();
      if (keys != nullptr) keys += batches[i].batch.begin;
      if (occlusion) {
        TraceOcclusion(tracer, rays, n, keys);
        mine->hit += CountOccluded(rays, n);
      } else {
        TraceClosest(tracer, rays, n, mine->hits, keys);
        mine->hit += CountHits(mine->hits, n);
      }
    });
  });
  const auto stop = std::chrono::steady_clock::now();
  for (const auto& mine : scratch) hits += mine->hit;
  return std::chrono::duration<double>(stop - start).count();
}

}  // namespace

ReplayTime Replay(RTCScene scene, Backend backend, const std::vector<RayRecorder>& recorders,
                  int threads) {
  std::vector<Batch> closest, occlusion;
  std::uint32_t rows = 1;
  for (const RayRecorder& recorder : recorders) {
    for (const RayBatch& batch : recorder.batches()) {
      (batch.occlusion ? occlusion : closest).push_back({&recorder, batch});
      rows = std::max(rows, batch.count);
    }
  }
  const Tracer tracer = {.scene = scene, .closest = backend, .occlusion = backend};
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  ReplayTime time;
  time.closest = ReplayKind(tracer, closest, false, arena, rows, time.closest_hits);
  time.occlusion = ReplayKind(tracer, occlusion, true, arena, rows, time.occlusion_hits);
  return time;
}

}  // namespace skywave
