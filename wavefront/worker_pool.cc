#include "wavefront/worker_pool.h"

#include <tbb/parallel_for.h>

#include "base/granted.h"
#include "wavefront/flush_denormals.h"

namespace skywave {

WorkerPool::WorkerPool(const RenderOptions& options, std::vector<RayRecorder>* recorders,
                       const std::atomic<bool>* cancel)
    : options_(options),
      arena_(ThreadsFor(options.threads)),
      recorders_(recorders),
      cancel_(cancel) {
  arena_.initialize();
  workers_.resize(std::size_t(threads()));
  if (recorders_ != nullptr) recorders_->resize(workers_.size());
}

void WorkerPool::ForEach(std::size_t count, const Work& work) {
  const auto work_on = [&](const tbb::blocked_range<std::size_t>& range) {
    const FlushDenormals flush;
    const auto thread = std::size_t(tbb::this_task_arena::current_thread_index());
    if (!workers_[thread]) workers_[thread] = MakeWorker(options_);
    RayRecorder* const recorder = recorders_ != nullptr ? &(*recorders_)[thread] : nullptr;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      CheckCanceled();
      work(i, *workers_[thread], recorder);
    }
  };
  arena_.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1), work_on,
                      tbb::simple_partitioner());
  });
}

RenderStats WorkerPool::stats() const {
  RenderStats sum;
  for (const std::unique_ptr<Worker>& worker : workers_) {
    if (worker) sum += worker->stats;
  }
  return sum;
}

}  // namespace skywave
