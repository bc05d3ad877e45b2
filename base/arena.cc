#include "base/arena.h"

#include <map>

#include "base/granted.h"

namespace skywave {

tbb::task_arena& ArenaOf(int wanted) {
  thread_local std::map<int, tbb::task_arena> arenas;
  const int threads = ThreadsFor(wanted);
  return arenas.try_emplace(threads, threads).first->second;
}

}  // namespace skywave
