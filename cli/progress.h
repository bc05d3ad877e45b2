// Shows the progress of a render: a bar with the remaining time on a terminal, an occasional plain
// line elsewhere.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/clock.h"
#include "job/watch.h"

namespace skywave {

// Prints to standard error. A line of a terminal that it has used is blank after its end.
class ProgressDisplay {
 public:
  ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;
  ~ProgressDisplay();
  // Takes the share that is done, in [0, 1]; prints if the last time is long enough ago.
  void Show(double done);

 private:
  bool terminal_;
  Clock::time_point start_, last_;
};

// Runs `work` and shows its progress to `total` meanwhile, unless `quiet` (see Watch).
void ShowProgress(bool quiet, std::uint64_t total, const WatchedWork& work);

// Prints each of `notes` as a line of standard error.
void PrintNotes(const std::vector<std::string>& notes);

}  // namespace skywave
