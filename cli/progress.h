// Shows the progress of a render: a bar with the remaining time on a terminal, an occasional plain
// line elsewhere.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/clock.h"
#include "job/watch.h"

namespace skywave {

// Prints to standard error. On a terminal its line is cleared when it is destroyed.
class ProgressDisplay {
 public:
  ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;
  ~ProgressDisplay();
  // Takes the share that is done, in [0, 1]. Prints nothing if it has just printed.
  void Show(double done);

 private:
  bool terminal_;
  Clock::time_point start_, last_;
};

// Runs `work` (see Watch) and meanwhile shows its progress to `total`, unless `quiet`.
void ShowProgress(bool quiet, std::uint64_t total, const WatchedWork& work);

// Prints each note as a line of standard error.
void PrintNotes(const std::vector<std::string>& notes);

}  // namespace skywave
