// The kernels refuse processors without an instruction set that they are compiled for.
#include "kernels/targets.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/support/targets.h"

namespace skywave {
namespace {

TEST(Targets, ThisProcessorIsAccepted) {
  for (const std::int64_t target : TestedTargets()) {
    const TargetScope scope(target);
    EXPECT_NO_THROW(RequireKernelTarget()) << hwy::TargetName(target);
  }
}

TEST(Targets, AProcessorWithoutACompiledSetIsRefusedInASentence) {
  if ((HWY_TARGETS & HWY_SSE4) != 0) GTEST_SKIP() << "skipped: SKYWAVE_TARGETS=all runs everywhere";
  const TargetScope scope(HWY_SSE4);
  try {
    RequireKernelTarget();
    FAIL() << "accepted";
  } catch (const std::runtime_error& error) {
    const std::string lowest = (HWY_TARGETS & HWY_AVX2) != 0 ? "AVX2" : "AVX-512";
    EXPECT_EQ(std::string(error.what()).rfind("this processor has no " + lowest + ",", 0), 0u)
        << error.what();
  }
}

}  // namespace
}  // namespace skywave
