#include "job/watch.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <future>

#include "base/spare_threads.h"

namespace skywave {

void Watch(std::uint64_t total, const WatchedWork& work, const Teller& tell) {
  Progress progress;
  Watch(progress, total, work, tell);
}

void Watch(Progress& progress, std::uint64_t total, const WatchedWork& work, const Teller& tell) {
  if (!tell) return work(progress);
  std::future<void> end = OnSpareThread([&] { work(progress); });
  std::exception_ptr failure;
  while (end.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready) {
    if (progress.cancel) continue;  // the work will notice soon
    try {
      const std::uint64_t expected = total - std::min<std::uint64_t>(progress.spared, total);
      const double done = double(progress.samples) / double(std::max<std::uint64_t>(expected, 1));
      if (!tell(std::min(done, 1.0))) progress.cancel = true;
    } catch (...) {
      failure = std::current_exception();
      progress.cancel = true;
    }
  }
  try {
    end.get();
  } catch (const RenderCanceled&) {
    if (!failure) throw;
  }
  if (failure) std::rethrow_exception(failure);
  if (progress.cancel) throw RenderCanceled();  // the work was done before it noticed
}

}  // namespace skywave
