// Tests that confined work gives its result and can do nothing else.
#include "base/confined.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace skywave {
namespace {

constexpr ConfinedLimits kLimits = {.memory_bytes = std::size_t{1} << 28, .seconds = 5};

// Returns what was wrong with `work`, or nothing.
std::string Problem(const std::function<void()>& work, const ConfinedLimits& limits = kLimits) {
  try {
    RunConfined(limits, work);
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

TEST(Confined, GivesItsResultInSharedMemoryOnly) {
  const SharedMemory shared(3 * sizeof(int));
  auto* const numbers = reinterpret_cast<int*>(shared.data());
  int own = 1;
  RunConfined(kLimits, [&] {
    std::vector<int> made(100000, 7);  // memory may be had
    numbers[2] = made[99999], own = 2;
  });
  EXPECT_EQ(numbers[0], 0);
  EXPECT_EQ(numbers[2], 7);
  EXPECT_EQ(own, 1);
}

TEST(Confined, ErrorsAndCrashesAreReported) {
  EXPECT_EQ(Problem([] { throw std::runtime_error("too short"); }), "too short");
  EXPECT_NE(Problem([] { throw 7; }), "");
  EXPECT_NE(Problem([] { std::abort(); }).find("signal"), std::string::npos);
  EXPECT_NE(Problem([] { std::_Exit(0); }), "") << "it did not end its work";
}

TEST(Confined, LimitsOfTimeAndMemoryHold) {
  const auto forever = [] {
    volatile bool ended = false;
    while (!ended) {
    }
  };
  EXPECT_NE(Problem(forever, {.memory_bytes = 1 << 28, .seconds = 1}).find("1 s of processor time"),
            std::string::npos);
  EXPECT_NE(Problem([] { std::vector<char> large(std::size_t{1} << 31, 'x'); }), "");
}

TEST(Confined, FilesAndProcessesAreOutOfReach) {
  const auto fails = [](bool done) {
    if (done) throw std::runtime_error("done");
  };
  EXPECT_EQ(Problem([&] { fails(open("/proc/self/stat", O_RDONLY) >= 0); }), "");
  EXPECT_EQ(Problem([&] { fails(fork() >= 0); }), "");
  EXPECT_EQ(Problem([&] { fails(write(STDERR_FILENO, "x", 1) >= 0); }), "");
  EXPECT_EQ(Problem([&] { fails(kill(getppid(), 0) >= 0); }), "");
}

}  // namespace
}  // namespace skywave
