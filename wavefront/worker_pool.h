// The threads of a frame and what each of them owns.
#pragma once

#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "wavefront/frame.h"
#include "wavefront/rays/ray_recorder.h"
#include "wavefront/stats.h"
#include "wavefront/worker.h"

namespace skywave {

// Work of a pool whose `cancel` has become true ends by this exception.
struct RenderCanceled {};

// An arena of threads, a worker for each thread that has had work, and, if rays are kept for a
// replay, a recorder for each. A thread makes its worker itself, so that it is the first one to
// touch the memory of the tables.
class WorkerPool {
 public:
  // Makes as many threads as `options` gives, whose workers have the tables of its integrator.
  // `recorders`, if not null, gets one for each thread; `cancel`, if not null, is watched.
  explicit WorkerPool(const RenderOptions& options, std::vector<RayRecorder>* recorders = nullptr,
                      const std::atomic<bool>* cancel = nullptr);

  // Runs `work` on the threads of the pool: parallel work in it uses no others.
  void Run(const std::function<void()>& work) { arena_.execute(work); }

  // Calls work(i, worker, recorder) for every i of [0, count) in any order, with the worker of the
  // thread and its recorder or null, denormals flushed to zero. Throws RenderCanceled.
  using Work = std::function<void(std::size_t i, Worker& worker, RayRecorder* recorder)>;
  void ForEach(std::size_t count, const Work& work);

  // Throws RenderCanceled if the pool is to end. ForEach calls it before each item, and long items
  // do so themselves.
  void CheckCanceled() const {
    if (cancel_ != nullptr && *cancel_) throw RenderCanceled();
  }

  int threads() const { return arena_.max_concurrency(); }
  // Returns the sum of what all workers have counted.
  RenderStats stats() const;

 private:
  RenderOptions options_;
  tbb::task_arena arena_;
  std::vector<std::unique_ptr<Worker>> workers_;  // by thread; null: it has had no work
  std::vector<RayRecorder>* recorders_;
  const std::atomic<bool>* cancel_;
};

}  // namespace skywave
