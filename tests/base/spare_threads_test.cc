// Tests work on threads that stay: results, exceptions, and that threads are used again.
#include "base/spare_threads.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace skywave {
namespace {

TEST(SpareThreads, GiveResultsAndExceptions) {
  EXPECT_EQ(OnSpareThread([] { return 7; }).get(), 7);
  std::future<void> failing = OnSpareThread([] { throw std::runtime_error("broken"); });
  EXPECT_THROW(failing.get(), std::runtime_error);
  auto owned = std::make_unique<int>(5);
  EXPECT_EQ(*OnSpareThread([owned = std::move(owned)]() mutable { return std::move(owned); }).get(),
            5);
}

// Each of these works waits for the next one to begin, so all need a thread at the same time.
TEST(SpareThreads, RunAllWorkAtOnce) {
  constexpr int kCount = 20;
  std::vector<std::promise<void>> begun(kCount);
  std::vector<std::future<void>> done;
  for (int i = 0; i < kCount; ++i) {
    done.push_back(OnSpareThread([&begun, i] {
      begun[std::size_t(i)].set_value();
      if (i + 1 < kCount) begun[std::size_t(i) + 1].get_future().wait();
    }));
  }
  for (std::future<void>& each : done) each.get();
}

TEST(SpareThreads, AreUsedAgain) {
  std::set<std::thread::id> threads;
  for (int i = 0; i < 200; ++i) {
    threads.insert(OnSpareThread([] { return std::this_thread::get_id(); }).get());
  }
  // A thread may not have come back yet when the next work is given.
  EXPECT_LT(threads.size(), 40u);
  EXPECT_FALSE(threads.contains(std::this_thread::get_id()));
}

// Python's multiprocessing forks processes that render after their parent has.
TEST(SpareThreads, AreThereInForkedProcesses) {
  EXPECT_EQ(OnSpareThread([] { return 1; }).get(), 1);
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);
    _exit(OnSpareThread([] { return 2; }).get());
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 2);
}

}  // namespace
}  // namespace skywave
