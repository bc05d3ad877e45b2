#include "cli/signals.h"

#include <signal.h>

#include <atomic>

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

}  // namespace

void CatchStopSignals() {
  const auto ask = [](int number) {
    if (!stop_asked.exchange(true)) return;
    ::signal(number, SIG_DFL);
    ::raise(number);
  };
  for (const int number : {SIGINT, SIGTERM}) Catch(number, ask, 0);
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
