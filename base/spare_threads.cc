#include "base/spare_threads.h"

#include <pthread.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace skywave {
namespace {

class SpareThreads {
 public:
  void Give(std::function<void()> work) {
    const std::lock_guard lock(mutex_);
    if (idle_ <= waiting_.size()) std::thread([this] { Serve(); }).detach();
    waiting_.push_back(std::move(work));
    given_.notify_one();
  }

 private:
  void Serve() {
    std::unique_lock lock(mutex_);
    while (true) {
      ++idle_;
      given_.wait(lock, [this] { return !waiting_.empty(); });
      --idle_;
      std::function<void()> work = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      work();
      work = nullptr;
      lock.lock();
    }
  }

  std::mutex mutex_;  // of what follows
  std::condition_variable given_;
  std::deque<std::function<void()>> waiting_;
  std::size_t idle_ = 0;  // threads
};

// Its threads wait until the process ends, so none is ever destroyed.
SpareThreads* of_process = nullptr;

// A process that was forked has none of the threads of its parent.
void BeginAnew() { of_process = new SpareThreads; }

}  // namespace

void GiveToSpareThread(std::function<void()> work) {
  static std::once_flag begun;
  std::call_once(begun, [] {
    BeginAnew();
    pthread_atfork(nullptr, nullptr, BeginAnew);
  });
  of_process->Give(std::move(work));
}

}  // namespace skywave
