// Tests that arenas stay, have their threads, and take no more memory with time.
#include "base/arena.h"

#include <gtest/gtest.h>
#include <tbb/parallel_pipeline.h>

#include <fstream>
#include <thread>

#include "base/granted.h"

namespace skywave {
namespace {

TEST(Arena, OfAThreadStays) {
  tbb::task_arena* const first = &ArenaOf(3);
  EXPECT_EQ(first, &ArenaOf(3));
  EXPECT_NE(first, &ArenaOf(2));
  EXPECT_EQ(first->max_concurrency(), 3);
  EXPECT_EQ(ArenaOf(0).max_concurrency(), GrantedHere().threads);
  std::thread([&] { EXPECT_NE(first, &ArenaOf(3)); }).join();
}

// Returns the memory of the process that is in use [kB].
long Resident() {
  std::ifstream file("/proc/self/statm");
  long pages = 0, resident = 0;
  file >> pages >> resident;
  return 4 * resident;
}

// Arenas that are made anew took 7 kB each here.
TEST(Arena, TakesNoMoreMemoryWithTime) {
  const auto run = [](int times) {
    for (int i = 0; i < times; ++i) {
      int next = 0;
      ArenaOf(2).execute([&] {
        tbb::parallel_pipeline(
            4, tbb::make_filter<void, int>(tbb::filter_mode::serial_in_order,
                                           [&](tbb::flow_control& control) {
                                             if (next == 3) control.stop();
                                             return next++;
                                           }) &
                   tbb::make_filter<int, int>(tbb::filter_mode::parallel, [](int n) { return n; }) &
                   tbb::make_filter<int, void>(tbb::filter_mode::serial_in_order, [](int) {}));
      });
    }
  };
  run(1000);
  const long before = Resident();
  run(1000);
  EXPECT_LT(Resident() - before, 4000);
}

}  // namespace
}  // namespace skywave
