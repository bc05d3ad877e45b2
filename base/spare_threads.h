// Work beside that of the caller, on threads that stay for more of it. std::async starts a thread
// each time, and oneTBB's allocator does not give back all that it has kept for a thread that ends:
// 25 kB for each picture of a batch.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <type_traits>
#include <utility>

namespace skywave {

// Runs `work` on a thread that has nothing else to do, and starts one if there is none.
void GiveToSpareThread(std::function<void()> work);

// The same with a result or an exception. Unlike that of std::async, the future does not wait when
// it is destroyed: whoever owns what `work` refers to has to.
template <class Work>
std::future<std::invoke_result_t<Work&>> OnSpareThread(Work work) {
  using Result = std::invoke_result_t<Work&>;
  const auto task = std::make_shared<std::packaged_task<Result()>>(std::move(work));
  std::future<Result> result = task->get_future();
  GiveToSpareThread([task] { (*task)(); });
  return result;
}

}  // namespace skywave
