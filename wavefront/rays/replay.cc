#include "wavefront/rays/replay.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>

#include "base/clock.h"
#include "base/granted.h"
#include "wavefront/flush_denormals.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

struct Batch {
  const RayRecorder* recorder;
  RayBatch batch;
};

// A thread traces in these tables and counts what it finds.
struct Scratch {
  explicit Scratch(std::uint32_t rows) : rays(rows), hits(rows) {}
  soa::Table<RayColumns> rays;
  soa::Table<HitColumns> hits;
  std::uint64_t hit = 0;  // rays that hit something
  double seconds = 0;     // in Embree
};

// Fills the first rows of a thread's table with a recorded batch.
void LoadRays(const Batch& b, const RayColumns& rays) {
  float* const org[3] = {rays.org_x, rays.org_y, rays.org_z};
  float* const dir[3] = {rays.dir_x, rays.dir_y, rays.dir_z};
  for (int axis = 0; axis < 3; ++axis) {
    std::copy_n(b.recorder->org(axis) + b.batch.begin, b.batch.count, org[axis]);
    std::copy_n(b.recorder->dir(axis) + b.batch.begin, b.batch.count, dir[axis]);
  }
  std::copy_n(b.recorder->t_far() + b.batch.begin, b.batch.count, rays.t_far);
}

std::uint64_t CountOccluded(const RayColumns& rays, std::uint32_t n) {
  return std::uint64_t(std::count_if(rays.t_far, rays.t_far + n, [](float t) { return t < 0; }));
}

std::uint64_t CountHits(const HitColumns& hits, std::uint32_t n) {
  return n - std::uint64_t(std::count(hits.geom, hits.geom + n, kNoHit));
}

std::vector<Batch> BatchesOf(RayKind kind, bool occlusion,
                             const std::vector<RayRecorder>& recorders) {
  std::vector<Batch> batches;
  for (const RayRecorder& recorder : recorders) {
    for (const RayBatch& batch : recorder.batches()) {
      if (batch.kind != kind || batch.occlusion != occlusion) continue;
      batches.push_back({&recorder, batch});
    }
  }
  return batches;
}

// Returns the seconds in Embree, the mean over the threads; adds the rays that hit something to
// `hits`. Only the calls are timed: a render's rays come from the stage before and lie in the
// cache, so fetching recorded ones from main memory is not part of the ceiling, and neither is
// counting hits.
double ReplayBatches(const Tracer& tracer, const std::vector<Batch>& batches, bool occlusion,
                     tbb::task_arena& arena, std::uint64_t& hits) {
  std::uint32_t rows = 1;
  for (const Batch& b : batches) rows = std::max(rows, b.batch.count);
  std::vector<std::unique_ptr<Scratch>> scratch(std::size_t(arena.max_concurrency()));
  for (auto& mine : scratch) mine = std::make_unique<Scratch>(rows);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, batches.size(), [&](std::size_t i) {
      Scratch& mine = *scratch[std::size_t(tbb::this_task_arena::current_thread_index())];
      const FlushDenormals flush;
      const std::uint32_t n = batches[i].batch.count;
      const std::uint32_t* keys = batches[i].recorder->keys();
      if (keys != nullptr) keys += batches[i].batch.begin;
      LoadRays(batches[i], mine.rays);
      const auto start = Clock::now();
      if (occlusion) {
        TraceOcclusion(tracer, mine.rays, n, keys);
      } else {
        TraceClosest(tracer, batches[i].batch.kind, mine.rays, n, mine.hits, keys);
      }
      mine.seconds += SecondsSince(start);
      mine.hit += occlusion ? CountOccluded(mine.rays, n) : CountHits(mine.hits, n);
    });
  });
  double seconds = 0;
  for (const auto& mine : scratch) hits += mine->hit, seconds += mine->seconds;
  return seconds / double(scratch.size());
}

}  // namespace

ReplayTime Replay(RTCScene scene, Backend backend, const std::vector<RayRecorder>& recorders,
                  int threads) {
  const Tracer tracer = {.scene = scene,
                         .closest = backend,
                         .occlusion = backend,
                         .beams = backend == Backend::kPacket};
  tbb::task_arena arena(ThreadsFor(threads));
  ReplayTime time;
  for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
    for (const bool occlusion : {false, true}) {
      const std::vector<Batch> batches = BatchesOf(RayKind(kind), occlusion, recorders);
      if (batches.empty()) continue;
      time.seconds[kind] += ReplayBatches(tracer, batches, occlusion, arena, time.hits[kind]);
    }
  }
  return time;
}

}  // namespace skywave
