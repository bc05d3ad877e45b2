// Signals ask a long render to save what it has and end, or to show it; others are errors of
// writing.
#pragma once

namespace skywave {

// The first SIGINT or SIGTERM asks for an end; a second signal, either of them, ends the process as
// usual.
void CatchStopSignals();
// True once an end has been asked for.
bool StopAsked();

// A write beyond the limit of file sizes (ulimit -f) fails with an error, like one on a full disk,
// instead of ending the process by SIGXFSZ.
void TakeFileLimitsAsErrors();

// Writing to a pipe that nobody reads fails instead of ending the process: long commands go on
// without those who have listened.
void OutliveClosedPipes();

// SIGUSR1 asks for a snapshot.
void CatchSnapshotSignal();
// True if a snapshot has been asked for since the last call.
bool TakeSnapshotAsked();

}  // namespace skywave
