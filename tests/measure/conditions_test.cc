// Tests what is told about a machine beside its times: what the kernel counts, in folders that are
// made up, and of this process.
#include "bench/measure/conditions.h"

#include <gtest/gtest.h>
#include <linux/perf_event.h>
#include <time.h>

#include <atomic>
#include <barrier>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "bench/measure/hardware_events.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

class MadeUpConditions : public testing::Test {
 protected:
  void Write(const std::string& path, const std::string& text) {
    const std::filesystem::path file = folder_.Path(path);
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  void WriteCounts(int ran, int waited, int stolen, int hot) {
    Write("proc/self/task/7/schedstat", std::to_string(ran) + " " + std::to_string(waited) + " 9");
    Write("proc/self/task/8/schedstat", "1000 0 1\n");
    const int idle = ran - 3150 - stolen;
    Write("proc/stat", "cpu  100 0 50 " + std::to_string(idle) + " 0 0 0 " +
                           std::to_string(stolen) + " 70 0\ncpu0 1 2 3\n");
    Write("sys/devices/system/cpu/cpu0/thermal_throttle/core_throttle_count", "5\n");
    Write("sys/devices/system/cpu/cpu1/thermal_throttle/core_throttle_count",
          std::to_string(hot) + "\n");
  }
  TemporaryFolder folder_;
};

TEST_F(MadeUpConditions, AreReadFromTheFilesOfTheKernel) {
  WriteCounts(4000, 300, 40, 2);
  const ConditionCounts counts = ReadConditions(folder_.Path(""));
  EXPECT_EQ(counts.ran, 5000u);
  EXPECT_EQ(counts.waited, 300u);
  EXPECT_EQ(counts.ticks, 1000u);  // what guests had is a part of the first figure
  EXPECT_EQ(counts.stolen, 40u);
  EXPECT_EQ(counts.throttled, 7u);
}

TEST_F(MadeUpConditions, GovernorsAreNamedOnce) {
  EXPECT_EQ(ReadGovernors(folder_.Path("")), "");
  for (const char* const processor : {"cpu0", "cpu1", "cpu2"}) {
    Write(std::string("sys/devices/system/cpu/") + processor + "/cpufreq/scaling_governor",
          processor == std::string("cpu1") ? "schedutil\n" : "performance\n");
  }
  EXPECT_EQ(ReadGovernors(folder_.Path("")), "performance,schedutil");
}

TEST_F(MadeUpConditions, WhatIsNotThereIsUnknown) {
  Write("proc/stat", "cpu  100 0 50\n");
  Write("proc/self/task/7/schedstat", "none\n");
  ConditionsWatch watch(folder_.Path(""));
  watch.Begin();
  watch.End();
  const Conditions found = watch.conditions();
  EXPECT_FALSE(found.waiting || found.stolen || found.throttled);
  EXPECT_TRUE(found.disturbances().empty());
}

// Counts before, between and after the periods are not theirs.
TEST_F(MadeUpConditions, AreThoseOfThePeriodsTogether) {
  ConditionsWatch watch(folder_.Path(""));
  const auto period = [&](int ran, int waited, int hot) {
    WriteCounts(4000, 50, 0, 5);
    watch.Begin();
    WriteCounts(4000 + ran, 50 + waited, 0, 5 + hot);
    watch.End();
  };
  period(900, 0, 0);
  period(70, 30, 1);
  const Conditions found = watch.conditions();
  EXPECT_DOUBLE_EQ(found.waiting.value(), 0.03);
  EXPECT_DOUBLE_EQ(found.stolen.value(), 0);
  EXPECT_EQ(found.throttled, 1u);
  const std::vector<std::string> disturbances = found.disturbances();
  ASSERT_EQ(disturbances.size(), 2u);
  EXPECT_EQ(disturbances[0], "its threads waited 3.0 % of their time for processors");
  EXPECT_EQ(disturbances[1], "heat slowed cores once");
  EXPECT_TRUE(
      (Conditions{.waiting = 0.01, .stolen = 0.005, .throttled = 0}.disturbances().empty()));
  EXPECT_EQ((Conditions{.waiting = {}, .stolen = 0.02, .throttled = {}}.disturbances().size()), 1u);
}

double ThreadSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// Runs threads that each use a processor for 20 ms; they live until `after` has been called.
template <class F>
void RunThreads(unsigned count, const F& after) {
  std::barrier done(std::ptrdiff_t(count) + 1), ended(std::ptrdiff_t(count) + 1);
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < count; ++i) {
    threads.emplace_back([&] {
      while (ThreadSeconds() < 0.02) {
      }
      done.arrive_and_wait();
      ended.arrive_and_wait();
    });
  }
  done.arrive_and_wait();
  after();
  ended.arrive_and_wait();
  for (std::thread& thread : threads) thread.join();
}

TEST(Conditions, ThreadsThatShareProcessorsWaitForThem) {
  if (!ReadConditions().waited) GTEST_SKIP() << "the kernel does not count waiting";
  ConditionsWatch watch;
  watch.Begin();
  RunThreads(4 * std::thread::hardware_concurrency(), [&] { watch.End(); });
  EXPECT_GT(watch.conditions().waiting.value(), 0.1);
  EXPECT_FALSE(watch.conditions().disturbances().empty());
}

// The clock of tasks is an event that all machines have.
TEST(HardwareEvents, CountThreadsThatAreStartedLater) {
  const ProcessEvent clock(PERF_TYPE_SOFTWARE, PERF_COUNT_SW_TASK_CLOCK);
  const std::optional<double> before = clock.Read();
  if (!before) GTEST_SKIP() << "the system does not let it ask";
  RunThreads(2, [&] { EXPECT_GT(clock.Read().value() - *before, 0.035e9); });
}

TEST(HardwareEvents, AreThoseOfThePeriodsAlone) {
  HardwareWatch watch;
  watch.Begin();
  RunThreads(2, [&] { watch.End(); });
  const std::optional<HardwareCounts> counts = watch.Take();
  if (!counts) GTEST_SKIP() << "the processor's events cannot be had";
  EXPECT_GT(counts->instructions_per_cycle(), 0.01);
  RunThreads(2, [] {});
  EXPECT_FALSE(watch.Take().has_value());
}

TEST(HardwareEvents, UnknownOnesAreNotCounted) {
  EXPECT_FALSE(ProcessEvent(0xFFFF, 0).Read().has_value());
}

}  // namespace
}  // namespace skywave
