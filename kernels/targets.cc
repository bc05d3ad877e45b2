#include "kernels/targets.h"

#include <stdexcept>

#include "hwy/highway.h"
#include "kernels/columns.h"

namespace skywave {
namespace {

// The better target has the smaller number.
std::int64_t BestTarget() {
  const std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
  return targets & -targets;
}

}  // namespace

void RequireKernelTarget() {
  if (BestTarget() != 0) return;
  const std::string lowest = (HWY_TARGETS & HWY_AVX2) != 0 ? "AVX2" : "AVX-512";
  throw std::runtime_error("this processor has no " + lowest +
                           ", which this build of Skywave needs; -DSKYWAVE_TARGETS=all builds it "
                           "for all processors");
}

std::string KernelTarget() { return hwy::TargetName(BestTarget()); }

std::uint32_t KernelLanes() {
  const std::int64_t target = BestTarget();
  if (target < HWY_AVX2) return kPadRows;
  return target == HWY_AVX2 ? 8 : target < HWY_EMU128 ? 4 : 1;
}

std::string HighwayVersion() {
  return std::to_string(HWY_MAJOR) + "." + std::to_string(HWY_MINOR) + "." +
         std::to_string(HWY_PATCH);
}

}  // namespace skywave
