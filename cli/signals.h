// Some signals ask a long render to save what it has and end, or to show it; the others become
// write errors or end the process.
#pragma once

namespace skywave {

// Gives the process the three standard streams, each of which may have been closed (`>&-`): the
// next file to be opened would take its place, and what is printed would get into that file.
// Reading or writing such a stream fails.
void KeepStandardStreams();

// SIGHUP, SIGINT, SIGQUIT, SIGPIPE, SIGTERM and SIGXCPU (a soft limit of CPU time) end the process
// after it has removed the files that it is writing. Those that it was started to ignore (nohup)
// stay ignored.
void EndWithoutUnfinishedFiles();

// The first SIGINT, SIGTERM or SIGHUP (the terminal is gone) asks for an end; a second signal, any
// of them, ends the process as usual. SIGHUP stays ignored under nohup.
void CatchStopSignals();
// True once an end has been asked for.
bool StopAsked();

// A write beyond the limit of file sizes (ulimit -f) fails with an error, like one on a full disk,
// instead of ending the process by SIGXFSZ.
void TakeFileLimitsAsErrors();

// Writing to a pipe that nobody reads fails instead of ending the process: long commands go on
// without their readers.
void OutliveClosedPipes();

// SIGUSR1 asks for a snapshot.
void CatchSnapshotSignal();
// True if a snapshot has been asked for since the last call.
bool TakeSnapshotAsked();

}  // namespace skywave
