// Tells callgrind which part of a run to count (bench/measure/instructions.h). The rest runs
// without its instrumentation if that is asked for (--instr-atstart=no): the start of the program
// takes most of its time otherwise. Costs some instructions where there is no valgrind.
#pragma once

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#endif

namespace skywave {

#ifdef CALLGRIND_START_INSTRUMENTATION
inline constexpr bool kMarksCountedRegions = true;

class CountedRegion {
 public:
  CountedRegion() { CALLGRIND_START_INSTRUMENTATION; }
  CountedRegion(const CountedRegion&) = delete;
  CountedRegion& operator=(const CountedRegion&) = delete;
  ~CountedRegion() { CALLGRIND_STOP_INSTRUMENTATION; }
};
#else
// Built without valgrind's header: everything is counted.
inline constexpr bool kMarksCountedRegions = false;
struct CountedRegion {
  CountedRegion() {}  // so that a variable of it counts as used
};
#endif

}  // namespace skywave
