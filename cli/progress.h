// Shows how far a render is: a bar with the time left on a terminal, a plain line now and then
// elsewhere.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

#include "wavefront/render.h"

namespace skywave {

// Prints to standard error from a thread of its own until it is destroyed.
class ProgressDisplay {
 public:
  ProgressDisplay(const Progress& done, std::uint64_t total);
  ~ProgressDisplay();

 private:
  void Show();

  const Progress& done_;
  std::uint64_t total_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace skywave
