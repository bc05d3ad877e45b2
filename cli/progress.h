// Shows the progress of a render: a bar with the remaining time on a terminal, an occasional plain
// line elsewhere.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

#include "wavefront/render.h"

namespace skywave {

// Prints to standard error from a separate thread until it is destroyed.
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
