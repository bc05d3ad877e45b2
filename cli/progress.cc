#include "cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace skywave {
namespace {

std::string Duration(double seconds) {
  const auto total = std::uint64_t(seconds + 0.5);
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{}:{:02}", total / 60, total % 60);
  return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
}

}  // namespace

ProgressDisplay::ProgressDisplay()
    : terminal_(isatty(STDERR_FILENO) != 0), start_(Clock::now()), last_(start_) {}

ProgressDisplay::~ProgressDisplay() {
  if (terminal_) fmt::print(stderr, "\r\033[K");
}

void ProgressDisplay::Show(double done) {
  // If standard error is not a terminal, a line every ten seconds suffices.
  if (SecondsSince(last_) < (terminal_ ? 0.2 : 10.0)) return;
  last_ = Clock::now();
  const std::string left =
      done > 0.01 ? Duration(SecondsSince(start_) / done * (1 - done)) + " left" : "estimating";
  if (terminal_) {
    constexpr int kWidth = 40;
    const int filled = int(done * kWidth);
    fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {:3.0f} %  {}   ", "", filled, "", kWidth - filled,
               done * 100, left);
  } else {
    fmt::print(stderr, "{:.0f} % rendered, {}\n", done * 100, left);
  }
  std::fflush(stderr);
}

void ShowProgress(bool quiet, std::uint64_t total, const WatchedWork& work) {
  if (quiet) return Watch(total, work, nullptr);
  ProgressDisplay display;
  Watch(total, work, [&](double done) {
    display.Show(done);
    return true;
  });
}

void PrintNotes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) fmt::print(stderr, "note: {}\n", note);
}

}  // namespace skywave
