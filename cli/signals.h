// Signals ask a long render to save what it has and end, or to show it.
#pragma once

namespace skywave {

// SIGINT and SIGTERM ask once for an end; a second one ends the process as usual.
void CatchStopSignals();
// True once an end has been asked for.
bool StopAsked();

// Writing beyond the limit of file sizes, or to a pipe that nobody reads, fails instead of ending
// the process. Long commands go on without those who have listened.
void FailWritesInsteadOfEnding();

// SIGUSR1 asks for a snapshot.
void CatchSnapshotSignal();
// True if a snapshot has been asked for since the last call.
bool TakeSnapshotAsked();

}  // namespace skywave
