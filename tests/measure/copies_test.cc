// Tests how many copies of the program are run at once, and how a long run is summed up.
#include "bench/measure/copies.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "bench/measure/sustain.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// Rates fall by 1 % a minute, and scatter by 0.1 %.
TEST(Sustain, DriftIsFoundWithItsInterval) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.001);
  std::vector<SustainedRound> rounds;
  for (int i = 0; i < 600; ++i) {
    rounds.push_back({.start = double(i), .rate = 1e6 * (1 - 0.01 * i / 60.0 + noise(random))});
  }
  const SustainedSpeed speed = SummarizeSustained(rounds, 600);
  EXPECT_EQ(speed.blocks.size(), std::size_t(kSustainBlocks));
  EXPECT_NEAR(speed.drift_per_minute.value, -0.01 / 0.95, 1e-4);
  EXPECT_LT(speed.drift_per_minute.interval.high, -0.01);
  EXPECT_GT(speed.drift_per_minute.interval.low, -0.011);
  EXPECT_NEAR(speed.last_to_first.value, 0.9125 / 0.9875, 1e-3);
  EXPECT_LT(speed.last_to_first.interval.high, 0.97);

  const SustainedSpeed one = SummarizeSustained({{.start = 0, .rate = 5}}, 1);
  EXPECT_EQ(one.first, 5);
  EXPECT_EQ(one.last_to_first.value, 1);
  EXPECT_TRUE(std::isnan(one.last_to_first.interval.low));
}

TEST(Copies, ArePinnedProcessesOfTheirOwn) {
  const std::vector<int> processors = ProcessorsByCore();
  ASSERT_FALSE(processors.empty());
  const std::vector<CopyResult> results = RunCopies(3, processors, [](CopyBarrier&) {
    cpu_set_t set;
    CPU_ZERO(&set);
    sched_getaffinity(0, sizeof set, &set);
    return std::to_string(::getpid()) + " " + std::to_string(CPU_COUNT(&set)) +
           std::string(100000, '.');  // more than a pipe holds
  });
  ASSERT_EQ(results.size(), 3u);
  EXPECT_NE(results[0].text, results[1].text);
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_NE(std::stoi(results[i].text), ::getpid());
    if (!results[i].processor) continue;  // where a system forbids it
    EXPECT_EQ(*results[i].processor, processors[i % processors.size()]);
    EXPECT_NE(results[i].text.find(" 1."), std::string::npos);
  }
}

TEST(Copies, ThatRotateAreAtDifferentParts) {
  using Order = std::vector<std::size_t>;
  EXPECT_EQ(PartsOfCopy(4, 3, false), (Order{0, 1, 2}));
  EXPECT_EQ(PartsOfCopy(0, 3, true), (Order{0, 1, 2}));
  EXPECT_EQ(PartsOfCopy(4, 3, true), (Order{1, 2, 0}));
  const std::vector<CopyResult> results =
      RunCopies(3, {}, [](CopyBarrier& barrier) { return std::to_string(barrier.copy()); });
  for (std::size_t i = 0; i < results.size(); ++i) EXPECT_EQ(results[i].text, std::to_string(i));
}

// One copy is late by 50 ms twice. After Meet, and after Finish, no copy is earlier than that one.
TEST(Copies, WaitForTheLastOne) {
  const TemporaryFolder folder;
  const auto begin = Clock::now();
  const std::vector<CopyResult> results =
      RunCopies(3, ProcessorsByCore(), [&](CopyBarrier& barrier) {
        const bool late = ::mkdir(folder.Path("late").c_str(), 0700) == 0;
        std::string text;
        for (int part = 1; part <= 2; ++part) {
          if (late) ::usleep(50000);
          barrier.Meet();
          text += SecondsSince(begin) >= 0.05 * (2 * part - 1) ? "y" : "n";
          if (late) ::usleep(50000);
          while (!barrier.Finish()) ::usleep(100);
          text += SecondsSince(begin) >= 0.05 * (2 * part) ? "y" : "n";
        }
        return text;
      });
  for (const CopyResult& result : results) EXPECT_EQ(result.text, "yyyy");
}

// The others wait in Meet, and are ended.
TEST(Copies, OneThatFailsEndsAll) {
  const auto run = [](const CopyWork& work) -> std::string {
    try {
      RunCopies(3, ProcessorsByCore(), work);
    } catch (const InputError& error) {
      return std::to_string(error.exit_code()) + " " + error.what();
    }
    return "";
  };
  // The copy on the second processor, or the only one, would fail; a file shows which copy is
  // first.
  const TemporaryFolder folder;
  const auto is_first = [&] { return ::mkdir(folder.Path("taken").c_str(), 0700) == 0; };
  const std::string thrown = run([&](CopyBarrier& barrier) -> std::string {
    if (is_first()) throw InputError(InputPosition::File("x.pbrt"), "is odd", kExitBadInput);
    barrier.Meet();
    return "";
  });
  EXPECT_NE(thrown.find("65 "), std::string::npos) << thrown;
  EXPECT_NE(thrown.find("x.pbrt: is odd"), std::string::npos) << thrown;
  ::rmdir(folder.Path("taken").c_str());
  const std::string killed = run([&](CopyBarrier& barrier) -> std::string {
    if (is_first()) ::raise(SIGKILL);
    barrier.Meet();
    return "";
  });
  EXPECT_NE(killed.find("ended by signal 9"), std::string::npos) << killed;
}

}  // namespace
}  // namespace skywave
