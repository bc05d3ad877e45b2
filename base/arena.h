// Arenas of threads for what runs in parallel.
#pragma once

#include <tbb/task_arena.h>

namespace skywave {

// Returns an arena of as many threads as ThreadsFor(wanted) says: that of the calling thread, which
// stays for all later calls. oneTBB 2021 loses up to 7 kB with each arena that is made and
// destroyed, which adds up over a batch.
tbb::task_arena& ArenaOf(int wanted);

}  // namespace skywave
