#include "cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "base/clock.h"

namespace skywave {
namespace {

std::string Duration(double seconds) {
  const auto total = std::uint64_t(seconds + 0.5);
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{}:{:02}", total / 60, total % 60);
  return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
}

}  // namespace

ProgressDisplay::ProgressDisplay(const Progress& done, std::uint64_t total)
    : done_(done), total_(total), thread_([this] { Show(); }) {}

ProgressDisplay::~ProgressDisplay() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void ProgressDisplay::Show() {
  using namespace std::chrono_literals;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const auto start = Clock::now();
  std::unique_lock lock(mutex_);
  // If standard error is not a terminal, a line every ten seconds suffices.
  while (!wake_.wait_for(lock, terminal ? 200ms : 10000ms, [this] { return stop_; })) {
    const double share = double(done_.load()) / double(total_);
    const double elapsed = SecondsSince(start);
    const std::string left =
        share > 0.01 ? Duration(elapsed / share * (1 - share)) + " left" : "estimating";
    if (terminal) {
      constexpr int kWidth = 40;
      const int filled = int(share * kWidth);
      fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {:3.0f} %  {}   ", "", filled, "", kWidth - filled,
                 share * 100, left);
    } else {
      fmt::print(stderr, "{:.0f} % rendered, {}\n", share * 100, left);
    }
    std::fflush(stderr);
  }
  if (terminal) fmt::print(stderr, "\r\033[K");
}

}  // namespace skywave
