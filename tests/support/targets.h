// Runs kernel tests on every instruction set, and at row counts that challenge loops.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cstdint>
#include <string>
#include <vector>

namespace skywave {

inline constexpr std::uint32_t kFullWave = 2048;
inline constexpr std::uint32_t kRowCounts[] = {0, 1, 2, 17, kFullWave};

// Restricts dispatch to one target for a scope.
class TargetScope {
 public:
  explicit TargetScope(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~TargetScope() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  TargetScope(const TargetScope&) = delete;
  TargetScope& operator=(const TargetScope&) = delete;
};

// Returns the targets that kernels/ is compiled for and this processor supports, best first.
inline std::vector<std::int64_t> TestedTargets() {
  std::vector<std::int64_t> targets;
  for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1)
    targets.push_back(rest & -rest);
  return targets;
}

// Calls run() once for every target, with dispatch set to it.
template <class Run>
void ForEachTarget(Run run) {
  for (const std::int64_t target : TestedTargets()) {
    const TargetScope scope(target);
    SCOPED_TRACE(std::string("on target ") + hwy::TargetName(target));
    run();
  }
}

// run() returns bits (a vector of integers) that must be the same on every target.
template <class Run>
void ExpectSameOnEveryTarget(Run run) {
  decltype(run()) first;
  bool have_first = false;
  ForEachTarget([&] {
    const auto bits = run();
    if (!have_first) {
      first = bits, have_first = true;
      return;
    }
    ASSERT_EQ(bits.size(), first.size());
    for (std::size_t i = 0; i < bits.size(); ++i) {
      ASSERT_EQ(bits[i], first[i]) << "word " << i << " differs from the best target's";
    }
  });
}

}  // namespace skywave
