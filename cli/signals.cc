#include "cli/signals.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>

#include "base/files.h"

namespace skywave {
namespace {

std::atomic<bool> stop_asked = false, snapshot_asked = false;
static_assert(std::atomic<bool>::is_always_lock_free, "handlers of signals may set these");

void Catch(int signal, void (*handler)(int), int flags) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags | SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

bool IsIgnored(int number) {
  struct sigaction now = {};
  sigaction(number, nullptr, &now);
  return now.sa_handler == SIG_IGN;
}

void End(int number) {
  RemoveUnfinishedFiles();
  ::signal(number, SIG_DFL);
  ::raise(number);
}

}  // namespace

void KeepStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    // A file gets the lowest free number. This one is open for the opposite direction, so using it
    // fails.
    [[maybe_unused]] const int opened =
        ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

void EndWithoutUnfinishedFiles() {
  for (const int number : {SIGHUP, SIGINT, SIGQUIT, SIGPIPE, SIGTERM, SIGXCPU}) {
    if (!IsIgnored(number)) Catch(number, End, 0);
  }
}

void CatchStopSignals() {
  const auto ask = [](int number) {
    if (stop_asked.exchange(true)) End(number);
  };
  for (const int number : {SIGINT, SIGTERM}) Catch(number, ask, 0);
  if (!IsIgnored(SIGHUP)) Catch(SIGHUP, ask, 0);
}

void TakeFileLimitsAsErrors() { Catch(SIGXFSZ, SIG_IGN, 0); }

void OutliveClosedPipes() { Catch(SIGPIPE, SIG_IGN, 0); }

bool StopAsked() { return stop_asked; }

void CatchSnapshotSignal() {
  Catch(
      SIGUSR1, [](int) { snapshot_asked = true; }, 0);
}

bool TakeSnapshotAsked() { return snapshot_asked.exchange(false); }

}  // namespace skywave
